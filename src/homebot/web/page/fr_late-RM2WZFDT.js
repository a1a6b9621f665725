var e=`12j 1nt xg kp 7jj e9 1ca 7b 6gn o4 1jy 16u 187 3l 43 1ys dl 2gl 9k l 16l dy 1tl mb 18g 1 2g jv ht 1ey b2g 2o9 57v 56 77i 19j 2ce eq 2dy f9 2u5 25s 6sh 2u 34u ds 6z 8u 1ck 15z dw fw tk 9a 3z9 dz 2d 2re 1sy 26q 4il 5th 9s 28y f4 fs 2do afh 8f 3i5 cv 61l 2hu 1 yw 2so 21l qk 1pk f8 49v h0 2nv 50y 1ws 50y 2qv sp qi 1p8 16f qf cf sm 8r ds 1m5 fv 6a 4pw 2p6 143 1bj 2ur 1px 3lz cz 18x 1x9 3eg 2dx 7on 1cp 3c 34y 11h 169 eh df da 8ls 1q9 x4 3xe 14o c7w 3ah 5z 5k 32g s0 l7 9fy 1xr 44j 27j ta g3 ep qk 6mh 12p 1og 1xv 15x 49 el 23l 328 5i 100 327 1wm 1xk 1ap 2t4 2v1 5x 2k 4s 2h8 1kc 2g6 2i9 2no r4 6rc 1v6 1q0 i9 32t 1av 42x xs 13 kd 112 3bm 1n4 1e2 b2 p6 1i3 wv 1w6 3qg 175 3jk g7 41r 2g7 3il 1pz 2g1 ro 3wh 1qt 26e oz 3rr 1tg 1c f3 6yx al 4so 17l 41w 6dv 1kc 1nd cu 1rj 7fv 59c 140 1be 3cm dw 4go 1li zh 4yb 68y c2 5d0 31 2er 3sa 43i 1kz 34i 4w8 13r 22m ak9 2ou 1q1 6gs 2nw v4 hm 3in ay dx 54a 8ph 8yp 1n2 226 5j4 3kr 8p c9 1ax 4x xt 2z1 2b9 1lj 7q3 8ma 7vl cel 24 5el xa mf 3wt 3xk 2qm 6vi hx 6bj 6o 4on byf 4ut t9 2h 405 2ht 1x7 1pt 1eb 4zo 6rz 9yz 53o a8 ow 1cc 3gv 3ej 7a 3r 226 ub 9jc 1v 2cw 8b p9 17l 149 13y 59b 2bs 3pw 1sj 5ho 1ho 17t 8mb fn 2jv rf c0p 2s 14d hy 2nz 1gt r4 1qs 31i 2z9 klp 18a 207 tj tg 3q 3g 2bl ji c 2s9 4x6 6xf 11b 14h 2e8 emi 2tj cz yw 1tn aa 34y 4ut 2y0 1y 2tz gr 2ny 60j 3jv 1nb th 1ew 5jo 7z 1pz 6mz 2pe 2mr tx 1ce 7d7 44g 1w8 x 2fx 11r a9 2m1 4ci 133 9l 72c 6i vc 5um nr 2dc 483 pv 3s 7gs e5 308 l6 447 ui 23k 233 1fi ca lq 2ct vi 23l bq 1ds z0 d6 31k 3ca 4i2 k2 4sq 2g3 1vq 3oz 2a8 26q 341 1r9 28q 344 3d0 1lc 28 13 3je oz z7 206 2gi cj x9 8u 4k5 2pp 7t 37h 3kx rh 2nq 84j 1cx 1bw 4sv 3y 4dy ox 1jt 1dk 1d0 1h 46 4ig r7 392 132 3ok 27c 33y 7j 3ql z4 1tg bg 303 11 28r 1tv 3e 976 6e4 40v bmc 1xq zn 5sd 4so 3u 5lg 38 4j1 3tr 13q 350 8xl 15c 1o8 18z 4m3 af jf 3yp 2vr 2q3 sw 176 7y f 2f4 14r 18b 27i 1q7 56i 2k2 38y 5g3 2s9 lu 1xh xr we 4f6 1ox r 179 ed6 18o 1lc 9r 1 2nd bd 59v 3yl 3zn o 13q 23e ij 9xx gb qp bu to 2ub a1g 11h 1b4 1p3 1cl 40g 1f3 7n3 32e zz ha 1sv 3h6 1pm 2gp 1kl 3qy 1f2 3qi 2d3 23v 5ta 5p 31l 2qw 9nh 5n 39d 28q 16x 3fr 58u 1e3 aa 2c 1h 38r y ep 5tz 3it pv q4 tn k3 18d akw 1ki 1kq 5on is 1nx 16s 19d 3f 2hr 3fi 5up 2zs 2m7 82 3pd 20r 3x7 6f 3lr 5j1 w3 171 kp h 1nr 8ry 16b 17q 42u vd 3po 11x z 26y 9x0 5jo l2 24d 4aw bm 6y 4et 125 35n 1ta 71r 1c5 2y 2f b8 27u 113 4rf 4f5 958 2el 1n7 2d4 32f 7wy 73a 1l1 3ly 4dj 8jf 4n fb 1ua 18k xh
il n'a pas r\xE9pondu \xE0 temps
Garage
Jardin
signale une manipulation
configuration erron\xE9e
passerelle
d\xE9tecteur de fuite
Sept jours
Ajouter
le robot a un ordre ; mettez d'abord son option sur idle
homebot tourne \xE0 l'essai et n'envoie rien
Journal technique
PM1
la table d'une passerelle a des secrets, aucune page ne la lit
Commandes
Pourquoi
le broker ne r\xE9pond plus
se d\xE9connecter
demande
\xE9checs du fichier des appareils
derni\xE8res fois
si elle d\xE9marre alors qu'elle tourne
faible
maintenant
a tourn\xE9
brut
en devenir propri\xE9taire, ou en nommer un autre dans HOMEBOT_DATA
\xE9tiquette
Y a-t-il un feu ? Sortez et appelez les pompiers
a signal\xE9 {values}
joint par
si homebot tourne d\xE9j\xE0, demandez-lui : homebot doctor
aucune route vers cette machine
when : ce qui la lance, une ligne chacun
pr\xE9r\xE9glage
aucun programme n'y r\xE9pond : d\xE9marrez-le, ou corrigez l'adresse
annuler
humidit\xE9 du sol
retour
plus t\xF4t
une de ses valeurs est inconnue
capteur de pluie
est d\xE9clench\xE9e
il en veut plusieurs \xE0 la fois, ce n'est pas possible
Aujourd'hui
depuis >
d\xE9shumidifie
normale
Jeton
la pi\xE8ce de l'appareil
Sujet
retard de la boucle d'\xE9v\xE9nements
Langue
Il faut : $
rapports
annonces refus\xE9es
pile faible
r\xE9installer le homebot plus r\xE9cent, ou : homebot restore BACKUP
Les nouvelles passerelles commencent au prochain d\xE9marrage de homebot.
aspirateurs qui ne sont pas encore des robots
il est occup\xE9
faire une sauvegarde
utiliser #
{issuer} a publi\xE9 {text}
un pont n'a pas de code : appuyez sur son bouton
remplacez-la ou chargez-la
la pi\xE8ce de l'appareil est inconnue, il y a donc peut-\xEAtre quelqu'un
fum\xE9e ou chaleur
donnez-en une, comme level 40
Un message conserv\xE9 le dit, sans dire depuis quand.
En vigueur d\xE8s maintenant.
Personnes
masquer
\xE9lev\xE9e
il a l'\xE9tiquette always_ask
l'\xE9tat de la maison
en retard de
accepte une date sans fuseau horaire
C'est ainsi depuis que homebot le conna\xEEt.
d\xE9tecteur de gel
le r\xE9seau l'a accept\xE9
Longitude
tout seul
Un jeton donne ses droits \xE0 cette page : le v\xF4tre est la ligne dans owner.token, dans le dossier de donn\xE9es de homebot. Pour une tablette, cr\xE9ez-en un avec :
foyer
Chargement du plan \u2026
robot
Omis, car secrets : {files}
annonces rejet\xE9es
Comme ntfy://TOPIC ou mailto://USER:PASSWORD@HOST ; appriseit.com les cite tous.
, par un autre programme
rien n'y a \xE9t\xE9 r\xE9uni
\xE9checs du journal
par un autre programme
connexions \xE9chou\xE9es
fabricant
abandonn\xE9s, trop longs
homebot why APPAREIL montre les signalements
Terrasse
accepte des nombres de 0 \xE0 360, 0 \xE0 100
homebot sait qui est \xE0 la maison par les t\xE9l\xE9phones du r\xE9seau et par les traceurs.
il y a >
heures calmes
{least} \xE0 {most}
Elle garde les valeurs actuelles de :
mode
est mouill\xE9
annonces
accepte true ou false
mode du ventilateur
prochaine fois
La maison est ouverte
montrer ce que permet l'accord pour #
if : tout ce qui doit alors \xEAtre vrai
climatiseur
ce n'a pas \xE9t\xE9 envoy\xE9
par {issuer}
Ceci est maintenant dans homebot.toml :
Nom et lieu
Les n\u0153uds \xE0 gauche publient des sujets, ceux \xE0 droite s'y abonnent.
le nom de la machine est inconnu : corrigez l'adresse
connexions refus\xE9es au mot de passe
arr\xEAt\xE9e
Rez-de-chauss\xE9e
topics refus\xE9s
\xE9tage
prenez un annuaire sur cet ordinateur, ou configurez son adresse
Historique
chaque fois
capteur d'ouverture
adresses refus\xE9es
fermez-le
accepte une date de 1970 \xE0 2106
c'est dans la configuration ; changez [places] l\xE0
mode
non connect\xE9
T\xE9l\xE9phone dans le r\xE9seau
dioxyde de carbone
la masquer dans la maison
Ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
n'accepte que true
il vient d'annoncer d'autres sujets, peut-\xEAtre ceux d'un autre appareil ; r\xE9essayez
Cet \xE9cran
{nodes} n\u0153uds et {topics} sujets
Adresse
temp\xE9rature de couleur
types refus\xE9s
traceur
ses lames ne font que s'ouvrir (100) et se fermer (0)
$ au fil du temps, * points
compos\xE9s organiques volatils
indisponible
sa m\xE9moire est pleine
vu en dernier
ce mode n'a pas cette consigne
copi\xE9
associer
annonces : octets en trop
il n'y a rien \xE0 annuler, ou le fichier a chang\xE9 depuis
recr\xE9\xE9
ne rien faire
son mod\xE8le ne donne rien pour cela
elle n'a pas de d\xE9tecteur de mouvement
homebot cherche dans l'historique de quatre semaines ce que vous faites r\xE9guli\xE8rement, et l'observe une semaine avant de le proposer.
homebot show APPAREIL
il n'a encore rien signal\xE9 depuis le d\xE9marrage de homebot
les associations avec Apple Home
Ni flamme ni interrupteur ; ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
nouvelle routine
store ou volet
Il n'y a encore ni serrure, ni contact, ni alarme.
plan de * pi\xE8ces
un nombre
Fuseau horaire
Chaque \xE9cran a son propre jeton, qui peut lui \xEAtre retir\xE9.
Ses appareils apparaissent ici.
quarantaines
n'en accepte pas
pression
r\xE9glage
en marche
Cette image n'est plus r\xE9cente.
Un serveur sur cet ordinateur
Un appareil sans valeur est retir\xE9.
il attend, une minute au plus, les appareils d'avant ; r\xE9essayez
le garder dans ce navigateur
il n'a pas d'ordre \xE0 poursuivre ; donnez-lui une destination
appareils refus\xE9s
laisser cette routine commander {names}
capteur de qualit\xE9 de l'air
Vos habitudes
la connexion \xE0 Home Assistant est perdue
Les alertes et les questions vont par ces adresses aux t\xE9l\xE9phones, aux messageries et au courrier.
il n'en a pas annonc\xE9
l'appareil r\xE9pond par une erreur
le robot n'a pas encore dit son \xE9tat
messages par seconde
l'adresse d'un flux, comme une radio
bouton
Son dernier \xE9v\xE9nement, qui n'est pas un \xE9tat :
commandes \xE9chou\xE9es
R\xE9cemment ici
enregistr\xE9
d\xE9tecteur de fum\xE9e ou de CO
d\xE9bitm\xE8tre
annonces : octets en m\xE9moire
force du signal
suivant
localiser
homebot ne peut pas red\xE9marrer seul ici ; relancez-le
Fum\xE9e, eau, mouvement
un nombre fini
mod\xE8le
aucune adresse
valeurs refus\xE9es
Rien ne s'est encore pass\xE9.
r\xE9ponses
plusieurs noms pour un identifiant : peut-\xEAtre plusieurs appareils
{issuer} a demand\xE9 {values}
Son bo\xEEtier est-il ouvert, ou est-il d\xE9croch\xE9 du mur ?
la connexion a \xE9t\xE9 ferm\xE9e
son pont ne l'atteint pas
tondeuse
Il a chang\xE9 \xE0 >.
d\xE9tecteur
l'appareil ne fait qu'\xE9mettre
Non compris \xE0 > :
disjoncteur
capteur de luminosit\xE9
Appuyez sur le bouton de l'appareil, puis sur \xAB associer \xBB.
le journal et homebot journal en disent plus
donnez \xE0 homebot un dossier accessible (HOMEBOT_DATA), ou lancez-le avec --ephemeral
capteur d'humidit\xE9
envoy\xE9 en un seul message au groupe #
tout
capteur de pression
Apps
Home Assistant a ferm\xE9 la connexion
Aucun appareil n'indique encore sa puissance ou son \xE9nergie.
clients coup\xE9s
pas encore connect\xE9
vanne d'eau
apr\xE8s un code faux, il veut une pause ; r\xE9essayez plus tard
bluetoothd ne tourne pas
inconnu : {names}
personne n'a \xE9t\xE9 pr\xE9venu ; [notify] et le journal disent pourquoi
mise \xE0 jour
Tout va bien.
Apr\xE8s cinq minutes, il montre une horloge sombre et ce qui est ouvert. L'adresse de cet \xE9cran :
envoy\xE9 en un seul message \xE0 la sc\xE8ne #
chauffe-eau
pr\xE9sence
red\xE9marrer #
refuser
annuler
vitesse
centrale d'alarme
compteur \xE9lectrique
Ce qui est connu, et d'o\xF9
une autre cl\xE9
Bureau
Sans compteur propre
aucune commande ne ram\xE8ne les gens chez eux
donnez password_file ou password_env dans [gateways.mdns.drivers.shelly]
graphe
Il n'y a rien \xE0 proposer.
Il n'y a pas (ou plus) d'appareil #.
fr\xE9quence
l'appareil n'a plus cette partie
# est associ\xE9.
Le chauffage marche fen\xEAtre ouverte
Chang\xE9 depuis le dernier accord :
do : ses \xE9tapes, une ligne chacune
ce n'est pas un pont Hue ; associez le pont dont il d\xE9pend
abonnements refus\xE9s
envoie ce que son annonce n'explique pas
derni\xE8re version
{energy} inject\xE9s
o\xF9 est cet \xE9cran
quand
la passerelle ne fait qu'observer ; autorisez-la \xE0 commander sous Syst\xE8me, Appareils
Sans TLS, un navigateur n'installe pas d'application : tls = true dans [door].
homebot tourne sans fichier ; d\xE9marrez-le dans un dossier avec homebot.toml
Rien n'est conserv\xE9 de cette p\xE9riode.
serrure
cr\xE9er un jeton
vous ne l'avez pas fait
Chargement des routines \u2026
HomeKit n'a pas de service pour cela
topics r\xE9serv\xE9s
progression de la mise \xE0 jour
rien n'a encore \xE9t\xE9 chang\xE9
donnez la cl\xE9 que sa configuration ESPHome a sous "api: encryption:" comme key_file, ou aucune
En attente de votre accord
pas de r\xE9ponse
Sauvegarde
Le code sur l'appareil
Montrer
aucune sc\xE8ne n'en garde
Home Assistant le refuse, ou le code est faux
nommez un appareil, ou cherchez comme 'light in hall'
faire
Alertes
demandes refus\xE9es
lecteur vid\xE9o
re\xE7us
Aucune pi\xE8ce n'a encore de forme. Donnez-lui des coins dans la table [places.rooms], ou importez une carte : homebot places import FICHIER.
donnez \xE0 chaque appareil un identifiant propre dans ses annonces ; d'ici l\xE0, ses parties ont ces noms
le code est faux
recherche \u2026
il ne prend pas de commandes, il signale seulement
une sc\xE8ne a des valeurs qui durent ; pour ce qui se fait une fois, prenez une routine
inoffensif
pas de D-Bus ; sous Linux, bluetoothd et le bus syst\xE8me doivent tourner
chaque \xE9tape
contradiction
r\xE9ponses inconnues
aucune voie n'y m\xE8ne les commandes
usager
trop de codes faux ; d\xE9branchez-le un instant
port
\xC9nergie par jour
heures et la maison
trouv\xE9s, et pas encore utilis\xE9s
Aucune app ne tourne.
renvoy\xE9
son mod\xE8le \xE9choue avec ce code
Chargement du graphe \u2026
messages perdus
recommencer
il ne peut \xEAtre observ\xE9
un programme inconnu
Appareils
fichier de donn\xE9es
surtout #
fr\xE9quence
modifier
on ou off
seule une personne r\xE9pond, sur la page
mis en service, mais ses attributs n'ont pu \xEAtre lus
un autre appareil est en cours d'association
aucun appareil trouv\xE9 avec ce code ; est-il pr\xEAt \xE0 l'association, sur ce r\xE9seau, et pas d\xE9j\xE0 associ\xE9 ?
annonces d\xE9riv\xE9es
c'est contradictoire ; n'en donnez qu'un
homebot show DEVICE montre les deux c\xF4t\xE9s ; homebot forget DEVICE y met fin
Entr\xE9e
m\xE9dia
coupez l'eau
il est injoignable
l'appareil ne peut qu'\xEAtre \xE9teint, comme une plaque par s\xE9curit\xE9
aucune route vers ce r\xE9seau
un autre mot de passe
les derni\xE8res 24 heures
Interrogation de homebot \u2026
Rien n'est encore compt\xE9.
il est silencieux depuis trop longtemps
trop longs
cela a \xE9t\xE9 annul\xE9
capteur de temp\xE9rature
a une pile faible
la commande ne tourne pas ; elle red\xE9marre d'elle-m\xEAme, voir Syst\xE8me
pile, courant, port\xE9e ?
rejet\xE9s
Couleurs
nettoyer des pi\xE8ces
accepte une date avec fuseau horaire
il a chang\xE9 depuis ; regardez-le de nouveau
seule une app ou routine peut en avoir un, par \`act\`
il n'y a plus d'\xE9v\xE9nements
\xE9nergie du {day}
annonces ignor\xE9es
le thermostat est dans un autre mode ; changez-le d'abord
Nom
True ou False
injoignable
sa convention a \xE9chou\xE9
pas ici
Latitude
balayage
vous l'avez fait > plus tard
Elle est en cours \u2026
homebot place APPAREIL PI\xC8CE
Diagnostic
chercher des habitudes
Code QR
Maintenant
permis
sans donner de raison
la corriger, puis : homebot config check
pile en charge
red\xE9marrer homebot apr\xE8s une nouvelle table : docs/protocols.md
vers la maison
Portes et fen\xEAtres
R\xE9cepteur le plus lent
Files et pertes
le serveur Matter a \xE9t\xE9 arr\xEAt\xE9
C'\xE9tait ainsi \xE0 son premier signalement.
cette question n'existe plus ; \`homebot answer\` liste les autres
observe : #
ajouter la table, et red\xE9marrer homebot : docs/robots.md
signale fum\xE9e ou chaleur
, de lui-m\xEAme
Personne
garder
tous \xE0 la maison
Aucun appareil n'indique encore de temp\xE9rature.
un mot de passe
\xC9tiquettes
notifications \xE9chou\xE9es
Sujets les plus actifs
fuite d'eau
ensuite
le serveur Matter est trop lent
l'annuaire n'a pas encore \xE9t\xE9 lu
attendre une minute, puis voir le journal de homebot
expirations abandonn\xE9es
notifications perdues
abandonn\xE9s, mal form\xE9s
Messages
le robot ne sait pas o\xF9 il est ; localisez-le d'abord
un autre chiffrement
capteur
une nouvelle pi\xE8ce
le client #
depuis le d\xE9marrage de cette passerelle il n'a pas dit ce qu'il sait faire ; s'il dort, r\xE9veillez-le
c'\xE9tait trop long
Elle contient tout ce que homebot garde, sauf les mots de passe.
favori
au repos
image
fautifs oubli\xE9s
sabotage
# peut commander les appareils
propos\xE9e par #
approbation
\xE9tats perdus
\xC9crans
Pendant la semaine d'essai vous l'avez fait {done} fois sur {total} ; une routine aurait raison dans {low} \xE0 {high} % des cas.
accepte plus de 0 et jusqu'\xE0 100 %
ouvert depuis longtemps
son autre consigne est inconnue, et les deux vont ensemble
, par l'appareil ou une personne
droits
action
, un \xE9cho
, par une personne
ce n'est pas un JPEG, PNG, GIF ou WebP de 2 Mio au plus
messages en attente ou perdus
rien n'en est connu qu'une sc\xE8ne pourrait r\xE9tablir
sa passerelle encode ses messages
pass\xE9 \xE0 {values}
lancer maintenant
Un point plein est allum\xE9, ouvert ou occup\xE9.
le broker
il a chang\xE9 depuis votre accord
mode
en attente
r\xE9gler
monoxyde de carbone
identifiants coup\xE9s
humidificateur
son mode est inconnu ; r\xE9glez-le d'abord
La maison est ferm\xE9e
Tout va bien. \xC0 noter :
un mot de passe seul irait en clair \xE0 qui se nomme ainsi : ajoutez "api: encryption:" \xE0 sa configuration ESPHome et donnez key_file, ou son adresse IP fixe comme allow_plaintext_at dans [gateways.mdns.drivers.esphome.devices.NAME]
une pression sur son bouton
robot aspirateur
est ouvert
retours perdus
ce homebot ne garde rien
Au mur
inconnu pour l'instant
Masqu\xE9s
aucune annonce valable depuis le d\xE9marrage de cette passerelle ; red\xE9marrez-le ou son pont, ou attendez
Le lieu donne le lever et le coucher du soleil ; il reste ici.
Ouvrez ceci une fois sur l'\xE9cran ; ce n'est affich\xE9 que maintenant :
Les premi\xE8res valeurs arrivent dans deux secondes.
continuer sans jeton
le code est faux ; si vous en \xEAtes s\xFBr, r\xE9essayez
since doit pr\xE9c\xE9der until
secret
il n'y a pas d'adresse : [notify] n'en a aucune
Jeton ou code
Chaque appareil a une pi\xE8ce.
commence par {view}
Routines toutes pr\xEAtes
\`homebot find\` montre ce qui va
Ce que vous changez ici, chaque \xE9cran le montre.
Le code qu'affiche homebot run laisse entrer un premier \xE9cran.
d\xE9bit
CoAP n'a pas cette m\xE9thode
Il peut
contest\xE9
, car {device} a signal\xE9 {values}
signale du monoxyde de carbone
annonces ambigu\xEBs
biblioth\xE8que manquante
le texte
annonces diff\xE9r\xE9es
connexion
il ne peut \xEAtre encod\xE9 en UTF-8
Dans l\u2019app Maison : +, Ajouter un accessoire, puis scannez ceci ou tapez le code.
corriger ou retirer l'\xE9metteur
ce protocole n'accepte pas de commandes brutes ; utilisez une adresse texte
routines toutes pr\xEAtes
d\xE9faillances
Associ\xE9 \xE0 * contr\xF4leurs.
teinte (0 \xE0 360) et saturation (0 \xE0 100), comme 0,100 pour rouge ou 240,50 pour bleu p\xE2le
Rien de mesur\xE9 ne fonctionne.
envoi \u2026
comme le syst\xE8me
les \xE9tiquettes n'acceptent pas de commandes
nouvelles manqu\xE9es
connexions refus\xE9es
\u2026 et * autres
il est associ\xE9 ailleurs ; retirez-le l\xE0-bas, ou r\xE9initialisez-le
fuite d'eau
ascenseur
, en chemin
regarder
perdus
lui donner le droit
Nom, pi\xE8ce et \xE9tiquettes
Utilisateur
valeurs
le profil de l'appareil n'a pas de trame pour cela
Aucune des * derni\xE8res entr\xE9es n'a ces mots.
un texte
Chambre
Ce qui garde cette sc\xE8ne n'en dit pas les valeurs.
hors de toutes les pi\xE8ces
il a \xE9t\xE9 annonc\xE9 apr\xE8s l'approbation de l'appareil
temp\xE9rature ambiante
Il n'y a pas encore de routine.
verrouillage
Salle de bain
r\xE9ponses tardives
toujours demander
demandes abandonn\xE9es
si
Les lignes apparaissent ici \xE0 mesure.
d\xE9tecteur de pr\xE9sence
il n'a pas d'adresse
ce homebot n'a pas de routines
corriger selon le journal : homebot app reload APP, homebot gateway restart NAME
il n'en a pas
clair
\xE0 la main ou tout seul
# est t\xE9l\xE9charg\xE9e ({size} ko).
, car la sc\xE8ne {scene} a \xE9t\xE9 annul\xE9e
messages non conserv\xE9s
Cuisine
balayage horizontal
Il n'a encore signal\xE9 aucun changement.
Qui la consomme
le propri\xE9taire ne l'a pas approuv\xE9
Boucle d'\xE9v\xE9nements
Valeurs, historique, faits
Valeurs
regarder et agir
la connexion a \xE9t\xE9 perdue
abandonn\xE9s, trop nombreux
un chiffrement
dossier des donn\xE9es
il demande un code
prend des pi\xE8ces, mais n'en a encore nomm\xE9 aucune
\xE9nergie inject\xE9e
le broker int\xE9gr\xE9 ne peut pas \xE9couter : tous les ports sont pris
il d\xE9sarme l'alarme
chauffage
Pour la restaurer :
son de la sir\xE8ne
encore * s
titre
Cave
les appareils de la maison ne sont pas encore connus
, car la sc\xE8ne {scene} a \xE9t\xE9 appliqu\xE9e
pi\xE8ce
supprimer #
absent
il refuse le mot de passe de password_file ou password_env dans [gateways.mdns.drivers.shelly]
capteur de sol
active
cela rend la maison plus s\xFBre
\xE0 la main
il n'est pas parmi ce que l'acc\xE8s peut commander
prendre les valeurs actuelles
perdus, lecture trop lente
corriger l'appareil ou son annonce
il faut des secondes, 0 ou plus
les plus r\xE9centes d'abord
Trouv\xE9s :
qualit\xE9 de l'air
un code Matter a 11 ou 21 chiffres, ou est un QR code qui commence par MT:
l'historique n'a pas commenc\xE9, ou est inutilisable ; \`homebot doctor\` dit pourquoi
pile, courant, port\xE9e ? S'il est parti pour de bon : homebot forget DEVICE
, \xE0 cause de $
seule la table d'une passerelle prend un mot de passe ou un jeton
accepte un nombre que son format peut \xE9crire
peut commander
Le message d'essai est envoy\xE9.
vous l'avez fait > avant
PM10
Le certificat auquel vos appareils doivent faire confiance
lecteur d'\xE9tiquettes
cet appareil n'existe pas
Aucun appareil pour l'instant.
le serveur Matter n'a pas de Bluetooth ; il n'atteint que les appareils du r\xE9seau
plan de * pi\xE8ce
{issuer} a \xE9t\xE9 refus\xE9 : &
le pont r\xE9pond quelque chose d'inconnu
Salon
{energy} kWh les autres jours semblables
accepter
Autres commandes
le journal a chacune avec sa trace : la signaler ou la corriger
Mot de passe
sombre
approuver #
perdus pour des absents
il redirige vers une autre machine, ce qui n'est pas suivi
en m\xEAme temps
se connecter
perdus (QoS 0)
commandes
son effet ne dure pas
red\xE9marrer homebot
signale du gaz
Appuyez sur le bouton : encore * s
rien
artiste
la porte est peut-\xEAtre ouverte
c'est fait une fois, et ne dure pas
ce n'est pas un proxy Bluetooth ; ajoutez "bluetooth_proxy:" \xE0 sa configuration ESPHome
sans pi\xE8ce
perdus, trop grands
commandes refus\xE9es
version
L'accord permet ces commandes :
vous, par $
messages refus\xE9s
valeurs illisibles
image de #
envoyer un message d'essai
il redirige trop souvent
signale un probl\xE8me
Aucun appareil de cette maison ne convient : $
\xE9criture \u2026
le jeton n'est plus valable, ou est celui d'un autre
il faut deux appareils diff\xE9rents
enregistrer
envoy\xE9
montrer`,n=`# asks, so another answers: use the owner's token, and give programs their own
# must ask itself
the question is over: &
the Matter server answered with error *
the bridge for HomeKit cannot listen on #, port *: &
it is not paired yet; $, with the code that is printed on it
it has no part #; it has $
its < is never below {least}, and it has no switch
it wants <; &
it takes percent; did you mean < %? To set $ %: #
it takes a text that matches $ of *
a number in $
by $? Its < is unknown; give a value, such as #
it has no room: $
# was switched back and forth * times within {span} s
# was switched back and forth * times within {span} s; with a token (\`homebot token new\`) a program may more often
a restart would lose this, as it was not written: &
# is in use by a running homebot
# is stated in the configuration; change [places] there
devices were placed in it: $; place them elsewhere first
no command gave it to #, which has <
no command stated the room of #
there is no device #, and no command stated its room
there may be * with {most} parts in all; remove one first
too many tests: wait for * s
approve it with \`homebot approve ^\`, and {advice}
if it can hurt nobody, \`homebot tag add ^ #\`, otherwise {advice}
there is no proposal * now; \`homebot suggest\` lists them
# is unsafe (&), and it changed since the owner approved it: $; approve it with \`homebot approve ^\`
the ^ # is not open
put the key that its ESPHome configuration has under "api: encryption: key:" into a file, and name that in [gateways.mdns.drivers.esphome.devices."^"] as key_file
put the one that its ESPHome configuration has under "api: password:" into a file, and name that in [gateways.mdns.drivers.esphome.devices."^"] as password_file
add "api: encryption:" to its ESPHome configuration, or remove the key in [gateways.mdns.drivers.esphome.devices."^"]
it is announced at <, and its allow_plaintext_at is $; &
a person must agree: &
whether # is on is unknown; say on or off
no device fits #; &
did you mean #?
nothing near # may be commanded; left out: $
not while {condition}: < is unknown
it takes a text that matches $
it takes a $ in ISO 8601 format
a command has 1 to *
it must be a text of * characters at most
there are * already; take some back
no import stated it; &
there are * decisions already; undo some
it has no announcement #; it has $
&; \`at_night\` (\`--night\`) allows it
somebody sleeps in ~ now
nothing was changed, as the values to put back cannot be kept: &
there is no device or picture #
no connection was made within * seconds
it has no characteristic #
no device is reachable: &
another proxy has its address #
the interface # cannot be used for < multicast: &
the ^ # cannot be opened: &
the ^ # cannot be <: &
no CoAP endpoint can be opened: &
no < multicast on the interface #: &
mDNS cannot be used on #: &
$ of [#] is for the address that is there; give it again with the other one
$ of [#] names a secret of this computer; only a person writes it into the file
it is longer than * characters
the embedded broker cannot listen: port * is taken
it did not announce # as a command topic
the embedded broker cannot listen: &
it wants $, and # is configured
it wants $, which is not supported
it does not encrypt; &
it takes a text of {least} to {most} characters
it takes a text of at most * characters
it takes a text of at most $
its template failed: $
its template $
it cannot be encoded as $
Home Assistant did not greet within * s
it would heat to {least} \xB0C, and cool to {most} \xB0C
HAP status *
the bridge of # is not connected
node * was commissioned, but the gateway has max_nodes already
the Matter gateway has no device #
the device answered with the status $
the device answered error $
the address # is unknown: &
the content type # is not understood
the observation of # ended
no copies can be made in #: &
it takes &, and no change
it offers no $
it has no script #; a table [[gateways.ble.proxies]] installs it
the robot takes no orders in its mode $
the table # is not among those that a page may change: $
the key # loads a program or a file; only a person writes it into the file
the right # is none that you may give; use: homebot token new
no backup has a byte *; begin with 0, which makes one
the change # of the layout has no names
the address # is not in the file any more; look at it again
gateway # starts again
gateway # is away: &
service # did not answer within * s; whether it acted is unknown
refused (<): &
changed back after * s, <
not sent: &
contradicted: &
the host name cannot be looked up now ($)
# has the lift
< closed the connection
# is not connected: &
# is not connected
# did not answer within * s
# is asleep; try again once it is awake
# is unavailable in Home Assistant
Home Assistant has no entity for the part # any more
# has no driver; \`homebot doctor\` names those that cannot be used
the certificate of # is not trusted
$: the server answered *, it may work later
the server answered *
it wants a password (status *)
it does not let homebot in with the password that is configured (status *)
it takes no <
it takes a number from {least} to {most}
it has no such setting; it takes {list}
# measured no change
there is no device with the id #
nobody is in ~
# has never detected anybody; walk past it once
# has been heard for only * s
&, and the scope of the client is $; add {right} to that, in the table [{table}] of homebot.toml
&, and the scope of the client is $
such a device needs a right that names it (&)
$, which outranks leases for * s more
<, by an old report: it is unreachable now
<, by an old report: last seen {age} ago
<, by a kept report: it has not reported itself yet
renamed # to $
rejected #; it is not proposed again
# does not run: &
a routine or app # is there already; choose another name, or edit that one
# is in the configuration; change it there, and then: $
there is nothing to undo: # was not applied, or was undone since
nothing that # changed is left to bring back
there is a scene # already
# is not in the house now; leave it as it is, or out
there may be *; remove one first
# was changed meanwhile; look at it, and try again
# is there already; remove it, or give the gateway another name
&, so it is exported by its name alone: $
it is not paired: $
# is not paired with homebot
the last reload was refused: &
no answer within * s
too many codes without a known effect by {issuer}
not while {condition}, and the state of # is unknown: &
somebody is in ~: # was on * s ago, and no door has been opened since
somebody may be in ~: # changed * s ago, and no command explains it
# needs a right that names it (&), and {issuer} has none; {advice}
# needs a right, because &, and {issuer} has none; {advice}
it is not on the list of harmless devices ($)
held at < by {holder} until it is released
held at < by {holder} for * s more
held < by {holder} until it is released
held < by {holder} for * s more
# said no
nobody answered within * s: a person does on the page, or with \`homebot answer\`
it is >, and quiet from {start} to {end}
the robot # is on its way in ~ or to it
somebody is in ~: $
somebody was in ~ * s ago: $
somebody may be in ~: $
it is unknown whether anybody is in ~: &
not while {condition}: $
its member # is refused it: &
{issuer} may not command #, only: $
{issuer} may not command #: &
no device can be reached: &
# cannot be reached: &
# is not on the network now
the connection to # was lost
it is a <
it is an <
it calls itself #
its unit is #
it heats up to * \xB0C
beside another part: &
the name # says $
the model # says $
gateway # does not report its state
problem of #
given up by #
failures in # since it started
counted by # in the last ten minutes
counted by # since it started
quarantined by #, which reads only some of their messages
note on #
gateway # is < and sends commands
gateway # is < and only observes: &
gateway # is < and only observes
it crashed ({error}) and starts again in >; at once: {text}
gateway # is <: &
&; restart homebot for the changes of {keys}
the file is as it was: &
* devices wait for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
1 device waits for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
the last notification was not sent: &
last seen {age} ago
done: $
held back: not $
$ failed: &
< (* %)
<, for {age}
# is unsafe (&), and <; approve it with \`homebot approve ^\`
the policy failed: $
* commands wait for their outcome
its gateway # is <: &
its gateway # is <
# did not answer $ within * s
no client subscribes to $
its button was not pressed within * s; press it and try again
pairing # was refused: &
$ was refused: &
# has no picture
^: # saw no effect of its last command; \`homebot trust $\` once it is repaired
it takes &
this part takes {list}
none of its modes is that: {list}
the device answered &
# is paired with homebot already
# is behind the bridge $, which is paired as a whole
&; try again in * s
it can only be turned < from here
there is a room # already
# is called that already
#: it is paired with another controller; remove it there, or reset it, then $
removed #
changed #
added #
# said yes
# does not answer
# did not answer
# takes no commands that homebot knows
* devices fit #; at most {most} may be commanded
$ was not sent to #: &
$ was sent to #: &
$ of #: &
# has $ already
# has no part
# cannot be reached with TLS: &
* Bluetooth proxies are connected already
# takes longer than * s for one answer
# is not known at any endpoint
# has no address of HTTP
# has no address
# answers no requests
# takes no message
# ended the stream of events
# cannot be announced as $: &
#: * commands are waiting for $ already
# cannot be opened: &
# was not set: &
# is paired by the code on it: $
# is commissioned already
# is behind the bridge $ (^); only the bridge can be removed
# does not answer the Matter server
# has not described itself yet
$ of # cannot be set
# cannot be written: &
# cannot be moved aside: &
# cannot be copied: &
# of $ cannot be kept in a file of its own
# = $ is no value of TOML; texts need quotes
# cannot be a name: give up to * printable characters
# cannot be $: &
it is >, and people sleep from {start} to {end}
\`$ --act ^\` gives one
$ act = [^] gives one
# at $: &
$ in steps of *
$ or more seconds
{least} to {most} s
# (&)
there is no < #; &
# demande, un autre r\xE9pond : prenez le jeton du propri\xE9taire
# doit demander lui-m\xEAme
la question est close : &
le serveur Matter r\xE9pond par l'erreur *
le pont pour HomeKit ne peut \xE9couter sur #, port * : &
pas encore associ\xE9 ; $, avec le code imprim\xE9 dessus
il n'a pas de partie #, mais $
< n'est jamais sous {least}, et il n'a pas d'interrupteur
il demande < ; &
prend des % ; vouliez-vous dire < % ? Pour $ % : #
il prend un texte de la forme $ (*)
un nombre en $
de $ ? < est inconnu ; donnez une valeur, comme #
il n'a pas de pi\xE8ce : $
# a bascul\xE9 * fois en {span} s
# a bascul\xE9 * fois en {span} s ; avec un jeton (\`homebot token new\`), un programme le peut plus souvent
non \xE9crit, donc perdu au red\xE9marrage : &
# est utilis\xE9 par un homebot en marche
# est dans la configuration ; changez-y [places]
il contient des appareils : $ ; placez-les d'abord ailleurs
aucune commande ne l'a donn\xE9 \xE0 # : <
aucune commande n'a dit la pi\xE8ce de #
il n'y a pas d'appareil #, et aucune commande n'a dit sa pi\xE8ce
au plus *, avec {most} parties ; retirez-en une d'abord
trop de tests : attendez * s
approuvez-le par \`homebot approve ^\`, et {advice}
s'il est inoffensif, \`homebot tag add ^ #\`, sinon {advice}
la proposition * n'existe plus ; \`homebot suggest\` les liste
# n'est pas sans danger (&), et il a chang\xE9 depuis votre approbation : $ ; approuvez-le avec \`homebot approve ^\`
^ # n'est pas ouvert
mettez ce que sa configuration ESPHome a sous "api: encryption: key:" dans un fichier, et nommez-le dans [gateways.mdns.drivers.esphome.devices."^"] comme key_file
mettez ce que sa configuration ESPHome a sous "api: password:" dans un fichier, et nommez-le dans [gateways.mdns.drivers.esphome.devices."^"] comme password_file
ajoutez "api: encryption:" \xE0 sa configuration ESPHome, ou retirez la cl\xE9 dans [gateways.mdns.drivers.esphome.devices."^"]
il s'annonce \xE0 <, mais allow_plaintext_at est $ ; &
quelqu'un doit \xEAtre d'accord : &
on ignore si # est allum\xE9 ; dites on ou off
aucun appareil ne correspond \xE0 # ; &
vouliez-vous dire # ?
rien ne peut \xEAtre command\xE9 pr\xE8s de # ; \xE9cart\xE9 : $
pas tant que {condition} : < est inconnu
accepte un texte de la forme $
accepte $ selon ISO 8601
une commande en a 1 \xE0 *
il faut un texte d'au plus * caract\xE8res
il y en a d\xE9j\xE0 * ; retirez-en
aucun import ne l'indique ; &
il y a d\xE9j\xE0 * d\xE9cisions ; annulez-en
il n'a pas d'annonce # ; il a $
& ; \`at_night\` (\`--night\`) le permet
quelqu'un dort maintenant dans ~
rien n'a chang\xE9, car les valeurs \xE0 remettre ne peuvent \xEAtre gard\xE9es : &
il n'y a pas d'appareil ni d'image #
pas de connexion en * s
il n'a pas de caract\xE9ristique #
aucun appareil n'est joignable : &
un autre proxy a son adresse #
l'interface # ne convient pas au multicast < : &
^ # ne peut \xEAtre ouvert : &
^ # ne peut \xEAtre < : &
aucun point CoAP ne peut \xEAtre ouvert : &
pas de multicast < sur l'interface # : &
mDNS ne peut servir sur # : &
$ de [#] vaut pour l'adresse actuelle ; redonnez-le avec la nouvelle
$ de [#] nomme un secret de cet ordinateur ; seule une personne l'\xE9crit dans le fichier
cela d\xE9passe * caract\xE8res
le broker int\xE9gr\xE9 ne peut pas \xE9couter : le port * est pris
il n'a pas annonc\xE9 # comme sujet de commande
le broker int\xE9gr\xE9 ne peut pas \xE9couter : &
il veut $, et # est configur\xE9
il veut $, ce n'est pas possible
il ne chiffre pas ; &
accepte un texte de {least} \xE0 {most} caract\xE8res
accepte un texte d'au plus * caract\xE8res
accepte un texte d'au plus $
son mod\xE8le \xE9choue : $
son mod\xE8le $
il ne peut \xEAtre encod\xE9 en $
Home Assistant ne s'est pas annonc\xE9 en * s
il chaufferait \xE0 {least} \xB0C et refroidirait \xE0 {most} \xB0C
\xE9tat HAP *
le pont de # n'est pas connect\xE9
le n\u0153ud * est en service, mais la passerelle a d\xE9j\xE0 max_nodes
la passerelle Matter n'a pas d'appareil #
l'appareil r\xE9pond avec l'\xE9tat $
l'appareil r\xE9pond par l'erreur $
l'adresse # est inconnue : &
le type de contenu # n'est pas compris
l'observation de # a pris fin
aucune copie ne peut \xEAtre faite dans # : &
accepte &, et aucun changement
il n'offre pas : $
il n'a pas de script # ; une table [[gateways.ble.proxies]] l'installe
le robot n'accepte aucun ordre dans son mode $
une page ne peut pas changer la table #, seulement : $
la cl\xE9 # charge un programme ou un fichier ; \xE9crivez-la vous-m\xEAme
vous ne pouvez pas donner le droit # ; utilisez : homebot token new
aucune sauvegarde n'a d'octet * ; commencez \xE0 0
le changement # ne nomme rien
l'adresse # n'est plus dans le fichier ; regardez-le \xE0 nouveau
la passerelle # red\xE9marre
la passerelle # est absente : &
# n'a pas r\xE9pondu en * s ; on ignore si c'est fait
refus\xE9 (<) : &
revenu apr\xE8s * s, <
non envoy\xE9 : &
contredit : &
le nom de la machine est introuvable en ce moment ($)
# a l'ascenseur
< a ferm\xE9 la connexion
# n'est pas connect\xE9 : &
# n'est pas connect\xE9
# n'a pas r\xE9pondu en * s
# dort ; r\xE9essayez quand il sera \xE9veill\xE9
# est indisponible dans Home Assistant
Home Assistant n'a plus d'entit\xE9 pour #
# n'a pas de pilote ; \`homebot doctor\` nomme les inutilisables
le certificat de # n'est pas fiable
$ : le serveur r\xE9pond *, \xE7a marchera peut-\xEAtre plus tard
le serveur r\xE9pond *
il demande un mot de passe (statut *)
il refuse homebot avec ce mot de passe (statut *)
ne prend pas : <
prend un nombre de {least} \xE0 {most}
il n'a pas ce r\xE9glage ; il prend {list}
# n'a mesur\xE9 aucun changement
il n'y a pas d'appareil #
personne n'est dans ~
# n'a jamais d\xE9tect\xE9 personne ; passez devant une fois
# n'est entendu que depuis * s
&, et l'acc\xE8s ne permet que $ ; ajoutez {right} dans [{table}] de homebot.toml
&, et l'acc\xE8s ne permet que $
un tel appareil demande un droit qui le nomme (&)
$, ce qui prime encore * s
<, selon un ancien message : injoignable maintenant
<, selon un ancien message : vu il y a {age}
<, selon un message gard\xE9 : il n'a encore rien dit lui-m\xEAme
# s'appelle maintenant $
# est rejet\xE9 et ne reviendra pas
# ne tourne pas : &
une routine ou app # existe d\xE9j\xE0 ; choisissez un autre nom, ou modifiez-la
# est dans la configuration ; changez-le l\xE0, puis : $
rien \xE0 annuler : # n'a pas \xE9t\xE9 appliqu\xE9e, ou l'a d\xE9j\xE0 \xE9t\xE9
plus rien de # n'est \xE0 r\xE9tablir
la sc\xE8ne # existe d\xE9j\xE0
# n'est pas dans la maison en ce moment ; laissez-le tel quel, ou enlevez-le
il peut y en avoir * ; enlevez-en un d'abord
# a chang\xE9 entre-temps ; regardez-le, et r\xE9essayez
# existe d\xE9j\xE0 ; supprimez-le, ou donnez un autre nom \xE0 la passerelle
&, donc seulement par son nom : $
il n'est pas associ\xE9 : $
# n'est pas associ\xE9 \xE0 homebot
le dernier rechargement a \xE9t\xE9 refus\xE9 : &
pas de r\xE9ponse en * s
trop de codes sans effet connu de {issuer}
pas tant que {condition}, et l'\xE9tat de # est inconnu : &
il y a quelqu'un dans ~ : # \xE9tait actif il y a * s, aucune porte ne s'est ouverte
quelqu'un est peut-\xEAtre dans ~ : # a chang\xE9 il y a * s, sans commande
# demande un droit qui le nomme (&), et {issuer} n'en a pas; {advice}
# demande un droit, car &, et {issuer} n'en a pas; {advice}
il n'est pas sur la liste des appareils sans danger ($)
maintenu \xE0 < par {holder} jusqu'\xE0 sa lib\xE9ration
maintenu \xE0 < par {holder} encore * s
maintenu par {holder} jusqu'\xE0 sa lib\xE9ration : <
maintenu par {holder} encore * s : <
# a dit non
personne n'a r\xE9pondu en * s : cela se fait sur la page ou avec \`homebot answer\`
il est >, et c'est le calme de {start} \xE0 {end}
le robot # roule dans ~ ou y va
il y a quelqu'un dans ~ : $
il y avait quelqu'un dans ~ il y a * s : $
il y a peut-\xEAtre quelqu'un dans ~ : $
on ne sait pas s'il y a quelqu'un dans ~ : &
pas tant que {condition} : $
le membre # refuse : &
{issuer} ne peut pas commander #, seulement : $
{issuer} ne peut pas commander # : &
aucun appareil n'est joignable : &
# est injoignable : &
# n'est pas sur le r\xE9seau en ce moment
la connexion \xE0 # a \xE9t\xE9 perdue
type : <
type : <
il se nomme #
son unit\xE9 est #
il chauffe jusqu'\xE0 * \xB0C
\xE0 c\xF4t\xE9 d'une autre partie : &
le nom # dit $
le mod\xE8le # dit $
la passerelle # ne dit pas son \xE9tat
probl\xE8me de #
abandonn\xE9 par #
d\xE9faillances dans # depuis le d\xE9marrage
compt\xE9 par # dans les dix derni\xE8res minutes
compt\xE9 par # depuis le d\xE9marrage
en quarantaine chez #, qui ne lit qu'une partie de leurs messages
note sur #
passerelle # : <, envoie des commandes
passerelle # : <, observe seulement : &
passerelle # : <, observe seulement
il a plant\xE9 ({error}) et red\xE9marre dans > ; tout de suite : {text}
passerelle # : < : &
& Apr\xE8s le red\xE9marrage de homebot : {keys}
Le fichier est inchang\xE9 : &
* appareils attendent une autorisation et ne re\xE7oivent rien avant : {list}
1 appareil attend une autorisation et ne re\xE7oit rien avant : {list}
le dernier message n'est pas parti : &
vu il y a {age}
fait : $
retenu : pas $
$ a \xE9chou\xE9 : &
< (* %)
<, depuis {age}
# n'est pas sans danger (&), et < ; approuvez-le avec \`homebot approve ^\`
la r\xE8gle a \xE9chou\xE9 : $
* commandes attendent leur r\xE9sultat
sa passerelle # est < : &
sa passerelle # est <
# n'a pas r\xE9pondu en * s : $
personne n'\xE9coute $
son bouton n'a pas \xE9t\xE9 press\xE9 en * s ; pressez-le et r\xE9essayez
# n'a pas \xE9t\xE9 associ\xE9 : &
$ a \xE9t\xE9 refus\xE9 : &
# n'a pas d'image
^ : # n'a vu aucun effet de sa derni\xE8re commande ; apr\xE8s r\xE9paration, \`homebot trust $\`
accepte : &
cette partie accepte : {list}
aucun de ses modes : {list}
l'appareil r\xE9pond : &
# est d\xE9j\xE0 associ\xE9 \xE0 homebot
# d\xE9pend du pont $, associ\xE9 en entier
& ; r\xE9essayez dans * s
d'ici, seulement : <
la pi\xE8ce # existe d\xE9j\xE0
# s'appelle d\xE9j\xE0 ainsi
# est associ\xE9 ailleurs ; dissociez-le ou r\xE9initialisez-le, puis $
# est supprim\xE9
# est modifi\xE9
# est ajout\xE9
# a dit oui
# ne r\xE9pond pas
# n'a pas r\xE9pondu
# n'accepte aucune commande que homebot conna\xEEt
* appareils correspondent \xE0 # ; au plus {most} \xE0 la fois
$ n'a pas \xE9t\xE9 envoy\xE9 \xE0 # : &
$ a \xE9t\xE9 envoy\xE9 \xE0 # : &
$ de # : &
# a d\xE9j\xE0 $
# n'a pas de partie
# est injoignable par TLS : &
* proxys Bluetooth sont d\xE9j\xE0 connect\xE9s
# met plus de * s pour r\xE9pondre
# n'est connu d'aucun point
# n'a pas d'adresse HTTP
# n'a pas d'adresse
# ne r\xE9pond \xE0 aucune demande
# n'accepte aucun message
# a mis fin aux \xE9v\xE9nements
# ne peut \xEAtre annonc\xE9 comme $ : &
# : * commandes attendent d\xE9j\xE0 $
# ne peut \xEAtre ouvert : &
# n'a pas \xE9t\xE9 r\xE9gl\xE9 : &
# s'associe par le code inscrit dessus : $
# est d\xE9j\xE0 mis en service
# d\xE9pend du pont $ (^) ; seul le pont peut \xEAtre retir\xE9
# ne r\xE9pond pas au serveur Matter
# ne s'est pas encore d\xE9crit
$ de # ne peut \xEAtre r\xE9gl\xE9
# ne peut \xEAtre \xE9crit : &
# ne peut \xEAtre mis de c\xF4t\xE9 : &
# ne peut \xEAtre copi\xE9 : &
# de $ ne peut avoir son propre fichier
# = $ n'est pas une valeur TOML ; un texte veut des guillemets
# ne peut \xEAtre un nom : donnez jusqu'\xE0 * caract\xE8res imprimables
# ne marche pas ($) : &
il est >, et l'on dort de {start} \xE0 {end}
\`$ --act ^\` en donne un
$ act = [^] en donne un
# \xE0 $ : &
$ par pas de *
$ secondes ou plus
{least} \xE0 {most} s
# (&)
il n'y a pas de < # ; &`;export{n as reasons,e as texts};
