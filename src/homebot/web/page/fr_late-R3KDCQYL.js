var e=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 2nx w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 21p 727 56y 5g 1sr 1 62v 1ir 1gj 61n nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 1zo 43 1z3 17l 6k kt f38 x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv d5u 1lo py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 32g 3b8 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 2hy 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu gyh ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 3ne 18n 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3j0 89 1qr el rb 1vc n5 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 811 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 2hh 18m 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 k9 1dh a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
plante
le code est faux
il a l'\xE9tiquette always_ask
le texte
\xE9checs du journal
Garage
Jardin
\xE9tats perdus
recommencer
{name} est t\xE9l\xE9charg\xE9e ({size} ko).
Il n'a encore signal\xE9 aucun changement.
d\xE9bitm\xE8tre
l'appareil ne fait qu'\xE9mettre
se connecter
qualit\xE9 de l'air
annonces refus\xE9es
r\xE9ponses tardives
comme le syst\xE8me
fabricant
si homebot tourne d\xE9j\xE0, demandez-lui : homebot doctor
garder
fichier de donn\xE9es
Ajouter
accepte plus de 0 et jusqu'\xE0 100 %
Terrasse
rapports
Journal technique
PM1
clients coup\xE9s
dioxyde de carbone
En vigueur d\xE8s maintenant.
Pourquoi
Au mur
Aucune des {count} derni\xE8res entr\xE9es n'a ces mots.
balayage
Pendant la semaine d'essai vous l'avez fait {done} fois sur {total} ; une routine aurait raison dans {low} \xE0 {high} % des cas.
il n'a encore rien signal\xE9 depuis le d\xE9marrage de homebot
demande
artiste
homebot show DEVICE montre les deux c\xF4t\xE9s ; homebot forget DEVICE y met fin
elle n'a pas de d\xE9tecteur de mouvement
action
dur\xE9e
chaud d\xE8s
Il n'y a encore ni serrure, ni contact, ni alarme.
faible
maintenant
le serveur Matter n'a pas de Bluetooth ; il n'atteint que les appareils du r\xE9seau
a tourn\xE9
brut
\xE9tiquette
sa passerelle encode ses messages
continuer sans jeton
{issuer} a demand\xE9 {values}
lecteur vid\xE9o
PM10
accepte un texte
vous l'avez fait {time} avant
envoi \u2026
Historique
les associations avec Apple Home
un programme inconnu
le serveur Matter a \xE9t\xE9 arr\xEAt\xE9
lui donner le droit
aucune sc\xE8ne n'en garde
un code Matter a 11 ou 21 chiffres, ou est un QR code qui commence par MT:
faire
cela a \xE9t\xE9 annul\xE9
Ce qui est connu, et d'o\xF9
cong\xE9lateur
son mode est inconnu ; r\xE9glez-le d'abord
port
types refus\xE9s
trop longs
hors de toutes les pi\xE8ces
perdus, lecture trop lente
est mouill\xE9
son autre consigne est inconnue, et les deux vont ensemble
r\xE9ponses inconnues
capteur d'ouverture
annonces rejet\xE9es
Alertes
mise \xE0 jour
Elle est en cours \u2026
Il a chang\xE9 \xE0 {time}.
par {issuer}
Une lumi\xE8re douce pour le chemin, la nuit.
favori
pile, courant, port\xE9e ?
Non compris \xE0 {time} :
mouvement
Diagnostic
il ne peut \xEAtre encod\xE9 en UTF-8
pr\xE9sence
les derni\xE8res 24 heures
Un serveur sur cet ordinateur
titre
aucun port TCP n'est libre pour le broker int\xE9gr\xE9
son mod\xE8le \xE9choue avec ce code
connexion
Un ventilateur tourne tant que la salle de bain est humide.
retours perdus
il faut des secondes, 0 ou plus
red\xE9marrer homebot
Il n'y a pas (ou plus) d'appareil {name}.
\xE0 la main ou tout seul
homebot why APPAREIL montre les signalements
homebot tourne \xE0 l'essai et n'envoie rien
son effet ne dure pas
son mod\xE8le ne donne rien pour cela
Utilisateur
il a chang\xE9 depuis ; regardez-le de nouveau
envoy\xE9 en un seul message au groupe {name}
la connexion \xE0 Home Assistant est perdue
finit
Commandes
compteur
notifications perdues
annuler
signale du monoxyde de carbone
cela rend la maison plus s\xFBre
a signal\xE9 {values}
il est silencieux depuis trop longtemps
approbation
Son bo\xEEtier est-il ouvert, ou est-il d\xE9croch\xE9 du mur ?
en attente
apr\xE8s un code faux, il veut une pause ; r\xE9essayez plus tard
plan de {count} pi\xE8ce
aucun programme n'y r\xE9pond : d\xE9marrez-le, ou corrigez l'adresse
d\xE9tecteur de fum\xE9e ou de CO
d\xE9tecteur de gel
ce n'est pas un pont Hue ; associez le pont dont il d\xE9pend
il a chang\xE9 depuis votre accord
{what} au fil du temps, {count} points
Rien ne s'est encore pass\xE9.
ce protocole n'accepte pas de commandes brutes ; utilisez une adresse texte
De la lumi\xE8re tant que quelqu'un bouge et qu'il fait sombre ; une lampe d\xE9j\xE0 allum\xE9e, ou que l'on commande entre-temps, reste comme elle est.
Qui la consomme
indisponible
Un jeton donne ses droits \xE0 cette page : le v\xF4tre est la ligne dans owner.token, dans le dossier de donn\xE9es de homebot. Pour une tablette, cr\xE9ez-en un avec :
Plus frais quand personne n'est l\xE0, chaud d\xE8s le premier qui rentre.
, par une personne
Comme ntfy://TOPIC ou mailto://USER:PASSWORD@HOST ; appriseit.com les cite tous.
la connexion a \xE9t\xE9 ferm\xE9e
accepte une date de 1970 \xE0 2106
ne rien faire
prenez un annuaire sur cet ordinateur, ou configurez son adresse
la table d'une passerelle a des secrets, aucune page ne la lit
r\xE9glage
r\xE9installer le homebot plus r\xE9cent, ou : homebot restore BACKUP
Un mot quand le garage reste ouvert, puis encore.
corriger la cause dans le journal, puis : homebot app reload APP, ou red\xE9marrer homebot
climatiseur
fragments perdus
Les nouvelles passerelles commencent au prochain d\xE9marrage de homebot.
capteur d'humidit\xE9
Les alertes et les questions vont par ces adresses aux t\xE9l\xE9phones, aux messageries et au courrier.
la commande ne tourne pas ; elle red\xE9marre d'elle-m\xEAme, voir Syst\xE8me
commandes \xE9chou\xE9es
\u2026 et {count} autres
il n'y a plus d'\xE9v\xE9nements
aucun appareil trouv\xE9 avec ce code ; est-il pr\xEAt \xE0 l'association, sur ce r\xE9seau, et pas d\xE9j\xE0 associ\xE9 ?
Associ\xE9 \xE0 {count} contr\xF4leurs.
permis
accepte des nombres de 0 \xE0 360, 0 \xE0 100
utiliser {name}
En attente de votre accord
sabotage
Personnes
c'est contradictoire ; n'en donnez qu'un
Ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
plus t\xF4t
, car la sc\xE8ne {scene} a \xE9t\xE9 appliqu\xE9e
enregistr\xE9
, car la sc\xE8ne {scene} a \xE9t\xE9 annul\xE9e
depuis {time}
n'accepte que true
le nom de la machine est inconnu : corrigez l'adresse
Latitude
la masquer dans la maison
observe : {name}
Les lignes apparaissent ici \xE0 mesure.
commence par {view}
Salon
corriger ou retirer l'\xE9metteur
accepte une date avec fuseau horaire
Il faut : {what}
les \xE9tiquettes n'acceptent pas de commandes
Ses appareils apparaissent ici.
Aucun appareil n'indique encore de temp\xE9rature.
L'aspirateur nettoie une fois par jour quand tout le monde est parti.
capteur de pluie
Un chauffage se repose tant que sa fen\xEAtre est ouverte.
n'en accepte pas
derni\xE8re version
mod\xE8le
if : tout ce qui doit alors \xEAtre vrai
messages perdus
dedans
heure du coucher
messages non conserv\xE9s
le client {name}
biblioth\xE8que manquante
humidit\xE9 du sol
chaque \xE9tape
Cette image n'est plus r\xE9cente.
annonces : octets en m\xE9moire
accepte on ou off
quand
apr\xE8s
quarantaines
remplacez-la ou chargez-la
une nouvelle pi\xE8ce
demandes refus\xE9es
Un message conserv\xE9 le dit, sans dire depuis quand.
bouton
vitesse
centrale d'alarme
aspirateurs qui ne sont pas encore des robots
Aucun appareil pour l'instant.
chauffe-eau
Code QR
\xC9tiquettes
il est injoignable
humide d\xE8s
sombre sous
jours
image de {name}
usager
{energy} inject\xE9s
modifier
homebot tourne sans fichier ; d\xE9marrez-le dans un dossier avec homebot.toml
Chaque appareil a une pi\xE8ce.
heure
Chambre
Maintenant
vu en dernier
limite
le broker ne r\xE9pond plus
associer
il demande un code
Sauvegarde
ajouter la table, et red\xE9marrer homebot : docs/robots.md
l'appareil n'a plus cette partie
Appuyez sur le bouton de l'appareil, puis sur \xAB associer \xBB.
la connexion a \xE9t\xE9 perdue
tondeuse
les plus r\xE9centes d'abord
Ce qui garde cette sc\xE8ne n'en dit pas les valeurs.
nouvelles manqu\xE9es
Aucun appareil de cette maison ne convient : {what}
suivant
trouv\xE9s, et pas encore utilis\xE9s
graphe
rien n'en est connu qu'une sc\xE8ne pourrait r\xE9tablir
Cet \xE9cran
Cave
il est associ\xE9 ailleurs ; retirez-le l\xE0-bas, ou r\xE9initialisez-le
un pont n'a pas de code : appuyez sur son bouton
Il peut
perdus pour des absents
rejet\xE9s
Baiss\xE9 aux deux tiers tant qu'il fait chaud.
{least} \xE0 {most}
Un mot quand une fen\xEAtre reste ouverte et qu'il fait froid dehors.
Un mot quand on consomme beaucoup un moment.
au repos
une sc\xE8ne a des valeurs qui durent ; pour ce qui se fait une fois, prenez une routine
Chargement du plan \u2026
fermez-le
mode
Portes et fen\xEAtres
joint par
c'est dans la configuration ; changez [places] l\xE0
, \xE0 cause de {what}
Autres commandes
il redirige trop souvent
Nom, pi\xE8ce et \xE9tiquettes
image
Fuseau horaire
Interrogation de homebot \u2026
passerelle
humidificateur
Une pression au lit : tout s'\xE9teint, et un mot si quelque chose est ouvert.
Il n'y a pas encore de routine.
T\xE9l\xE9phone dans le r\xE9seau
fr\xE9quence
Ni flamme ni interrupteur ; ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
Il n'y a rien \xE0 proposer.
pas de r\xE9ponse
adresses refus\xE9es
Sujets les plus actifs
Nom
autre
Plus frais la nuit.
Un mot quand une plante a soif.
nommez un appareil, ou cherchez comme 'light in hall'
propos\xE9e par {name}
lecteur d'\xE9tiquettes
prochaine fois
annuler
signale une manipulation
Longitude
Nom et lieu
son de la sir\xE8ne
\xE9nergie du {day}
Une prise s'\xE9teint la nuit si son appareil ne fait qu'attendre.
Home Assistant le refuse, ou le code est faux
connexions refus\xE9es
Routines toutes pr\xEAtes
{issuer} a publi\xE9 {text}
soir
monoxyde de carbone
De la lumi\xE8re dans l'entr\xE9e quand la porte s'ouvre dans le noir.
capteur de sol
Aucun appareil n'indique encore sa puissance ou son \xE9nergie.
a une pile faible
abandonn\xE9s, trop longs
si
abandonn\xE9s, mal form\xE9s
Chaud le matin et le soir.
temp\xE9rature de couleur
Chaque \xE9cran a son propre jeton, qui peut lui \xEAtre retir\xE9.
messages en attente ou perdus
il redirige vers une autre machine, ce qui n'est pas suivi
demandes abandonn\xE9es
l'annuaire n'a pas encore \xE9t\xE9 lu
\xC9nergie par jour
est d\xE9clench\xE9e
Rez-de-chauss\xE9e
heures calmes
en devenir propri\xE9taire, ou en nommer un autre dans HOMEBOT_DATA
when : ce qui la lance, une ligne chacun
peut commander
Montrer
Le code sur l'appareil
\xE9checs du fichier des appareils
annonces : octets en trop
Un bouton commande une lampe.
enregistrer
accepte true ou false
Valeurs
envoy\xE9
annonces diff\xE9r\xE9es
froid sous
Vos habitudes
signale du gaz
montrer
Mot de passe
r\xE9gler
cet appareil n'existe pas
il n'en a pas
Les premi\xE8res valeurs arrivent dans deux secondes.
fuite d'eau
sa description ne nomme pas le param\xE8tre
Y a-t-il un feu ? Sortez et appelez les pompiers
annonces d\xE9riv\xE9es
Une sonnerie est annonc\xE9e, et \xE9claire l'entr\xE9e dans le noir.
derni\xE8res fois
commandes
capteur de temp\xE9rature
la pi\xE8ce de l'appareil est inconnue, il y a donc peut-\xEAtre quelqu'un
Un appareil sans valeur est retir\xE9.
La maison est ferm\xE9e
temp\xE9rature ambiante
active
robot
cr\xE9er un jeton
surtout {name}
inconnu : {names}
inoffensif
coupez l'eau
le journal a chacune avec sa trace : la signaler ou la corriger
aucune route vers cette machine
ce n'est pas un proxy Bluetooth ; ajoutez "bluetooth_proxy:" \xE0 sa configuration ESPHome
Salle de bain
le broker
Un mot quand un cong\xE9lateur est trop chaud un moment.
rien n'y a \xE9t\xE9 r\xE9uni
Masqu\xE9s
est ouvert
Ceci est maintenant dans homebot.toml :
il n'a pas d'ordre \xE0 poursuivre ; donnez-lui une destination
Boucle d'\xE9v\xE9nements
d\xE9tecteur
Entr\xE9e
approuver {name}
trop de codes faux ; d\xE9branchez-le un instant
la porte est peut-\xEAtre ouverte
verrouillage
Sans compteur propre
Tout va bien. \xC0 noter :
Messages
Aucune pi\xE8ce n'a encore de forme. Donnez-lui des coins dans la table [places.rooms], ou importez une carte : homebot places import FICHIER.
commence
signale fum\xE9e ou chaleur
contradiction
masquer
\xE9lev\xE9e
il a \xE9t\xE9 annonc\xE9 apr\xE8s l'approbation de l'appareil
vous ne l'avez pas fait
il n'en a pas annonc\xE9
lancer maintenant
Le code qu'affiche homebot run laisse entrer un premier \xE9cran.
\xE9nergie inject\xE9e
connexions refus\xE9es au mot de passe
personne n'a \xE9t\xE9 pr\xE9venu ; [notify] et le journal disent pourquoi
seule la table d'une passerelle prend un mot de passe ou un jeton
\xC9crans
le robot a un ordre ; mettez d'abord son option sur idle
valeurs refus\xE9es
C'\xE9tait ainsi \xE0 son premier signalement.
Le message d'essai est envoy\xE9.
o\xF9 est cet \xE9cran
toujours demander
annonces ignor\xE9es
, en chemin
Valeurs, historique, faits
Elle garde les valeurs actuelles de :
Elle contient tout ce que homebot garde, sauf les mots de passe.
ce mode n'a pas cette consigne
Un point plein est allum\xE9, ouvert ou occup\xE9.
Pour la restaurer :
ce homebot ne garde rien
homebot show APPAREIL
dossier des donn\xE9es
il faut deux appareils diff\xE9rents
Sept jours
traceur
\xE0 la main
Home Assistant a ferm\xE9 la connexion
le code est faux ; si vous en \xEAtes s\xFBr, r\xE9essayez
identifiants coup\xE9s
la passerelle ne fait qu'observer ; autorisez-la \xE0 commander sous Syst\xE8me, Appareils
La maison est ouverte
pas ici
Chang\xE9 depuis le dernier accord :
routines toutes pr\xEAtes
signale un probl\xE8me
il n'y a rien \xE0 annuler, ou le fichier a chang\xE9 depuis
recherche \u2026
Son dernier \xE9v\xE9nement, qui n'est pas un \xE9tat :
c'est fait une fois, et ne dure pas
vers la maison
balayage horizontal
Ouvrez ceci une fois sur l'\xE9cran ; ce n'est affich\xE9 que maintenant :
Le lieu donne le lever et le coucher du soleil ; il reste ici.
le robot n'a pas encore dit son \xE9tat
pr\xE9r\xE9glage
il d\xE9sarme l'alarme
capteur
prendre les valeurs actuelles
Une lampe est allum\xE9e du cr\xE9puscule au coucher tant que quelqu'un est l\xE0.
topics r\xE9serv\xE9s
appareils refus\xE9s
{name} est associ\xE9.
chauffage
non connect\xE9
reste
Personne
perdus (QoS 0)
luminosit\xE9
since doit pr\xE9c\xE9der until
Aucune app ne tourne.
accepte une date sans fuseau horaire
Chargement des routines \u2026
attendre une minute, puis voir le journal de homebot
plusieurs noms pour un identifiant : peut-\xEAtre plusieurs appareils
il en veut plusieurs \xE0 la fois, ce n'est pas possible
foyer
\xE9tage
l'appareil ne peut qu'\xEAtre \xE9teint, comme une plaque par s\xE9curit\xE9
pas encore connect\xE9
le profil de l'appareil n'a pas de trame pour cela
L'accord permet ces commandes :
le jeton n'est plus valable, ou est celui d'un autre
par un autre programme
retour
secret
sonnette
\xE9criture \u2026
Les n\u0153uds \xE0 gauche publient des sujets, ceux \xE0 droite s'y abonnent.
, de lui-m\xEAme
expirations abandonn\xE9es
R\xE9cepteur le plus lent
le thermostat est dans un autre mode ; changez-le d'abord
, un \xE9cho
vous l'avez fait {time} plus tard
accepter
HomeKit n'a pas de service pour cela
Trouv\xE9s :
injoignable
Le certificat auquel vos appareils doivent faire confiance
la corriger, puis : homebot config check
force du signal
Apr\xE8s cinq minutes, il montre une horloge sombre et ce qui est ouvert. L'adresse de cet \xE9cran :
C'est ainsi depuis que homebot le conna\xEEt.
ce n'a pas \xE9t\xE9 envoy\xE9
compteur \xE9lectrique
arr\xEAt\xE9e
store ou volet
Chargement du graphe \u2026
Jeton ou code
serrure
envoy\xE9 en un seul message \xE0 la sc\xE8ne {name}
, par un autre programme
rien n'a encore \xE9t\xE9 chang\xE9
mode du ventilateur
Tout va bien.
accepte un nombre que son format peut \xE9crire
Le chauffage marche fen\xEAtre ouverte
ce n'est pas un JPEG, PNG, GIF ou WebP de 2 Mio au plus
il y a {time}
perdus, trop grands
corriger l'appareil ou son annonce
mode
vous, par {what}
si elle d\xE9marre alors qu'elle tourne
Appareils
Omis, car secrets : {files}
envoyer un message d'essai
Rien n'est encore compt\xE9.
homebot ne peut pas red\xE9marrer seul ici ; relancez-le
retard de la boucle d'\xE9v\xE9nements
le journal et homebot journal en disent plus
red\xE9marrer homebot apr\xE8s une nouvelle table : docs/protocols.md
nouvelle routine
fr\xE9quence
localiser
commandes refus\xE9es
le serveur Matter est trop lent
ensuite
en retard de
contest\xE9
{name} peut commander les appareils
donnez-en une, comme level 40
pression
chaque fois
d\xE9tecteur de fuite
vanne d'eau
matin
re\xE7us
donnez \xE0 chaque appareil un identifiant propre dans ses annonces ; d'ici l\xE0, ses parties ont ces noms
tous \xE0 la maison
fuite d'eau
ouvert depuis longtemps
ascenseur
d\xE9tecteur de pr\xE9sence
topics refus\xE9s
aucune commande ne ram\xE8ne les gens chez eux
regarder
perdus
r\xE9ponses
Appuyez sur le bouton : encore {count} s
CoAP n'a pas cette m\xE9thode
R\xE9cemment ici
do : ses \xE9tapes, une ligne chacune
plan de {count} pi\xE8ces
sans pi\xE8ce
en m\xEAme temps
pile en charge
De la lumi\xE8re et un mot quand il y a de l'eau o\xF9 il n'en faut pas.
supprimer {name}
capteur de pression
faire une sauvegarde
il n'a pas d'adresse
messages refus\xE9s
{nodes} n\u0153uds et {topics} sujets
annonces ambigu\xEBs
compos\xE9s organiques volatils
Rien n'est conserv\xE9 de cette p\xE9riode.
regarder et agir
capteur de luminosit\xE9
droits
Apps
pile faible
disjoncteur
Un mot aussit\xF4t quand une porte s'ouvre et que personne n'est l\xE0.
abonnements refus\xE9s
refuser
Aujourd'hui
pass\xE9 \xE0 {values}
envoie ce que son annonce n'explique pas
Jeton
pi\xE8ce
{issuer} a \xE9t\xE9 refus\xE9 : {reason}
Sujet
homebot sait qui est \xE0 la maison par les t\xE9l\xE9phones du r\xE9seau et par les traceurs.
absent
Des lampes s'allument et s'\xE9teignent le soir quand personne n'est l\xE0.
Un mot quand le lave-linge a fini.
sa convention a \xE9chou\xE9
abaiss\xE9
, par l'appareil ou une personne
le garder dans ce navigateur
notifications \xE9chou\xE9es
pile, courant, port\xE9e ? S'il est parti pour de bon : homebot forget DEVICE
d\xE9shumidifie
Bureau
Files et pertes
Rien de mesur\xE9 ne fonctionne.
Ce que vous changez ici, chaque \xE9cran le montre.
ses lames ne font que s'ouvrir (100) et se fermer (0)
abandonn\xE9s, trop nombreux
sombre
Sans TLS, un navigateur n'installe pas d'application : tls = true dans [door].
version
connexions \xE9chou\xE9es
robot aspirateur
Couleurs
valeurs illisibles
une pression sur son bouton
se d\xE9connecter
tout seul
encore {count} s
il n'y a pas d'adresse : [notify] n'en a aucune
configuration erron\xE9e
Une lampe s'\xE9claircit vingt minutes avant le lever.
Il n'y a pas d'image.
renvoy\xE9
montrer ce que permet l'accord pour {name}
homebot cherche dans l'historique de quatre semaines ce que vous faites r\xE9guli\xE8rement, et l'observe une semaine avant de le proposer.
les appareils de la maison ne sont pas encore connus
il ne peut \xEAtre observ\xE9
Fum\xE9e, eau, mouvement
Cuisine
Tout s'\xE9teint quand tout le monde est parti.
Adresse
le propri\xE9taire ne l'a pas approuv\xE9
d\xE9bit
fum\xE9e ou chaleur
ouvert depuis
, car {device} a signal\xE9 {values}
laisser cette routine commander {names}
mode
Langue
Baiss\xE9 au cr\xE9puscule, lev\xE9 le matin.
tout
le r\xE9seau l'a accept\xE9
chercher des habitudes
il n'est pas parmi ce que l'acc\xE8s peut commander
{energy} kWh les autres jours semblables
normale
capteur de qualit\xE9 de l'air
messages par seconde
en marche
inconnu pour l'instant
d\xE9faillances
clair
fautifs oubli\xE9s
une de ses valeurs est inconnue
un autre appareil est en cours d'association
Dans l\u2019app Maison : +, Ajouter un accessoire, puis scannez ceci ou tapez le code.
homebot place APPAREIL PI\xC8CE
annonces`,n=`a person must agree: {reason}
whether {name} is on is unknown; say on or off
no device fits {name}; {reason}
did you mean {name}?
nothing near {name} may be commanded; left out: {what}
not while {condition}: {name} is unknown
it takes a text that matches {what}
it takes a {what} in ISO 8601 format
a command has 1 to {count}
it must be a text of {count} characters at most
there are {count} already; take some back
no import stated it; {reason}
there are {count} decisions already; undo some
it has no announcement {name}; it has {what}
the bridge for HomeKit cannot listen on {name}: {reason}
{reason}; \`at_night\` (\`--night\`) allows it
somebody sleeps in {room} now
nothing was changed, as the values to put back cannot be kept: {reason}
there is no device or picture {name}
no connection was made within {count} seconds
it has no characteristic {name}
no device is reachable: {reason}
another proxy has its address {name}
the interface {name} cannot be used for {value} multicast: {reason}
no CoAP endpoint can be opened: {reason}
no {value} multicast on the interface {name}: {reason}
mDNS cannot be used on {name}: {reason}
it did not announce {name} as a command topic
the embedded broker cannot listen: {reason}
it wants another encryption; {reason}
it wants {what}, and {name} is configured
it wants {what}, which is not supported
it wants encryption; {reason}
it wants another password; {reason}
it wants {what}; {reason}
it does not encrypt; {reason}
it takes a text of {least} to {most} characters
it takes a text of at most {count} characters
it takes a text of at most {what}
its template failed: {what}
its template {what}
it cannot be encoded as {what}
Home Assistant did not greet within {count} s
it would heat to {least} \xB0C, and cool to {most} \xB0C
HAP status {count}
the bridge of {name} is not connected
node {count} was commissioned, but the gateway has max_nodes already
the Matter gateway has no device {name}
the device answered with the status {what}
the device answered error {what}
the address {name} is unknown: {reason}
the content type {name} is not understood
the observation of {name} ended
no copies can be made in {name}: {reason}
it takes {what}, and no change
it offers no {what}
it has no script {name}; a table [[gateways.ble.proxies]] installs it
the robot takes no orders in its mode {what}
the table {name} is not among those that a page may change: {what}
the key {name} loads a program or a file; only a person writes it into the file
the right {name} is none that you may give; use: homebot token new
no backup has a byte {count}; begin with 0, which makes one
the change {name} of the layout has no names
the address {name} is not in the file any more; look at it again
gateway {name} is away: {reason}
service {name} did not answer within {count} s; whether it acted is unknown
refused ({value}): {reason}
changed back after {count} s, {value}
not sent: {reason}
contradicted: {reason}
the host name cannot be looked up now ({what})
{name} has the lift
{value} closed the connection
{name} is not connected: {reason}
{name} is not connected
{name} did not answer within {count} s
{name} is asleep; try again once it is awake
{name} is unavailable in Home Assistant
Home Assistant has no entity for the part {name} any more
{name} has no driver; \`homebot doctor\` names those that cannot be used
the certificate of {name} is not trusted
{what}: the server answered {count}, it may work later
the server answered {count}
it wants a password (status {count})
it does not let homebot in with the password that is configured (status {count})
it takes no {value}
it takes a number from {least} to {most}
it has no such setting; it takes {list}
{name} measured no change
there is no device with the id {name}
nobody is in {room}
{name} has never detected anybody; walk past it once
{name} has been heard for only {count} s
{reason}, and the scope of the client is {what}; add {right} to that, in the table [{table}] of homebot.toml
{reason}, and the scope of the client is {what}
such a device needs a right that names it ({reason})
{what}, which outranks leases for {count} s more
{value}, by an old report: it is unreachable now
{value}, by an old report: last seen {age} ago
{value}, by a kept report: it has not reported itself yet
renamed {name} to {what}
rejected {name}; it is not proposed again
{name} does not run: {reason}
a routine or app {name} is there already; choose another name, or edit that one
{name} is in the configuration; change it there, and then: {what}
there is nothing to undo: {name} was not applied, or was undone since
nothing that {name} changed is left to bring back
there is a scene {name} already
{name} is not in the house now; leave it as it is, or out
there may be {count}; remove one first
{name} was changed meanwhile; look at it, and try again
{name} is there already; remove it, or give the gateway another name
{reason}, so it is exported by its name alone: {what}
it is not paired: {what}
{name} is not paired with homebot
the last reload was refused: {reason}
no answer within {count} s
too many codes without a known effect by {issuer}
not while {condition}, and the state of {name} is unknown: {reason}
somebody is in {room}: {name} was on {count} s ago, and no door has been opened since
somebody may be in {room}: {name} changed {count} s ago, and no command explains it
{name} needs a right that names it ({reason}), and {issuer} has none{what}
{name} needs a right, because {reason}, and {issuer} has none{what}
it is not on the list of harmless devices ({what})
held at {value} by {holder} until it is released
held at {value} by {holder} for {count} s more
held {value} by {holder} until it is released
held {value} by {holder} for {count} s more
{name} said no
nobody answered within {count} s: a person does on the page, or with \`homebot answer\`
it is {time}, and quiet from {start} to {end}
somebody is in {room}: {what}
somebody was in {room} {count} s ago: {what}
somebody may be in {room}: {what}
it is unknown whether anybody is in {room}: {reason}
{name} was switched back and forth {count} times within {span} s
not while {condition}: {what}
its member {name} is refused it: {reason}
{issuer} may not command {name}, only: {what}
{issuer} may not command {name}: {reason}
no device can be reached: {reason}
{name} cannot be reached: {reason}
{name} is not on the network now
the connection to {name} was lost
it is a {value}
it is an {value}
it calls itself {name}
its unit is {name}
it heats up to {count} \xB0C
beside another part: {reason}
the name {name} says {what}
the model {name} says {what}
gateway {name} does not report its state
problem of {name}
given up by {name}
failures in {name} since it started
counted by {name} in the last ten minutes
counted by {name} since it started
quarantined by {name}, which reads only some of their messages
note on {name}
gateway {name} is {value} and sends commands
gateway {name} is {value} and only observes: {reason}
gateway {name} is {value} and only observes
gateway {name} is {value}: {reason}
{reason}; restart homebot for the changes of {keys}
the file is as it was: {reason}
{count} devices wait for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
1 device waits for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
the last notification was not sent: {reason}
last seen {age} ago
done: {what}
held back: not {what}
{what} failed: {reason}
{value} ({count} %)
{value}, for {age}
{name} is unsafe ({reason}), and {value}; approve it with {what}
the policy failed: {what}
{count} commands wait for their outcome
its gateway {name} is {value}: {reason}
its gateway {name} is {value}
{name} did not answer {what} within {count} s
no client subscribes to {what}
its button was not pressed within {count} s; press it and try again
pairing {name} was refused: {reason}
{what} was refused: {reason}
{name} has no picture
{id}: {name} saw no effect of its last command; \`homebot trust {what}\` once it is repaired
{name} ({reason})
it takes {what}
this part takes {list}
none of its modes is that: {list}
the device answered {what}
{name} is paired with homebot already
{name} is behind the bridge {what}, which is paired as a whole
{reason}; try again in {count} s
it can only be turned {value} from here
there is a room {name} already
{name} is called that already
{name}: it is paired with another controller; remove it there, or reset it, then {what}
removed {name}
changed {name}
added {name}
{name} said yes
{name} does not answer
{name} did not answer
{name} takes no commands that homebot knows
{count} devices fit {name}; at most {most} may be commanded
{what} was not sent to {name}: {reason}
{what} was sent to {name}: {reason}
{what} of {name}: {reason}
{name} has {what} already
{name} has no part
{name} cannot be reached with TLS: {reason}
{count} Bluetooth proxies are connected already
{name} takes longer than {count} s for one answer
{name} is not known at any endpoint
{name} has no address of HTTP
{name} has no address
{name} answers no requests
{name} takes no message
{name} ended the stream of events
{name} cannot be announced as {what}: {reason}
{name}: {count} commands are waiting for {what} already
{name} cannot be opened: {reason}; {what}
{name} cannot be opened: {reason}
{name} was not set: {reason}
{name} is paired by the code on it: {what}
{name} is commissioned already
{name} is behind the bridge {what} ({id}); only the bridge can be removed
{name} does not answer the Matter server
{name} has not described itself yet
{what} of {name} cannot be set
{name} cannot be written: {reason}
{name} cannot be moved aside: {reason}
{name} is not open
{name} cannot be copied: {reason}
{name} cannot be recreated: {reason}
{name} of {what} cannot be kept in a file of its own
{name} = {what} is no value of TOML; texts need quotes
{name} cannot be a name: give up to {count} printable characters
{name} cannot be {what}: {reason}
quelqu'un doit \xEAtre d'accord : {reason}
on ignore si {name} est allum\xE9 ; dites on ou off
aucun appareil ne correspond \xE0 {name} ; {reason}
vouliez-vous dire {name} ?
rien ne peut \xEAtre command\xE9 pr\xE8s de {name} ; \xE9cart\xE9 : {what}
pas tant que {condition} : {name} est inconnu
accepte un texte de la forme {what}
accepte {what} selon ISO 8601
une commande en a 1 \xE0 {count}
il faut un texte d'au plus {count} caract\xE8res
il y en a d\xE9j\xE0 {count} ; retirez-en
aucun import ne l'indique ; {reason}
il y a d\xE9j\xE0 {count} d\xE9cisions ; annulez-en
il n'a pas d'annonce {name} ; il a {what}
le pont HomeKit ne peut pas \xE9couter sur {name} : {reason}
{reason} ; \`at_night\` (\`--night\`) le permet
quelqu'un dort maintenant dans {room}
rien n'a chang\xE9, car les valeurs \xE0 remettre ne peuvent \xEAtre gard\xE9es : {reason}
il n'y a pas d'appareil ni d'image {name}
pas de connexion en {count} s
il n'a pas de caract\xE9ristique {name}
aucun appareil n'est joignable : {reason}
un autre proxy a son adresse {name}
l'interface {name} ne convient pas au multicast {value} : {reason}
aucun point CoAP ne peut \xEAtre ouvert : {reason}
pas de multicast {value} sur l'interface {name} : {reason}
mDNS ne peut servir sur {name} : {reason}
il n'a pas annonc\xE9 {name} comme sujet de commande
le broker int\xE9gr\xE9 ne peut pas \xE9couter : {reason}
il veut un autre chiffrement ; {reason}
il veut {what}, et {name} est configur\xE9
il veut {what}, ce n'est pas possible
il veut un chiffrement ; {reason}
il veut un autre mot de passe ; {reason}
il veut {what} ; {reason}
il ne chiffre pas ; {reason}
accepte un texte de {least} \xE0 {most} caract\xE8res
accepte un texte d'au plus {count} caract\xE8res
accepte un texte d'au plus {what}
son mod\xE8le \xE9choue : {what}
son mod\xE8le {what}
il ne peut \xEAtre encod\xE9 en {what}
Home Assistant ne s'est pas annonc\xE9 en {count} s
il chaufferait \xE0 {least} \xB0C et refroidirait \xE0 {most} \xB0C
\xE9tat HAP {count}
le pont de {name} n'est pas connect\xE9
le n\u0153ud {count} est en service, mais la passerelle a d\xE9j\xE0 max_nodes
la passerelle Matter n'a pas d'appareil {name}
l'appareil r\xE9pond avec l'\xE9tat {what}
l'appareil r\xE9pond par l'erreur {what}
l'adresse {name} est inconnue : {reason}
le type de contenu {name} n'est pas compris
l'observation de {name} a pris fin
aucune copie ne peut \xEAtre faite dans {name} : {reason}
accepte {what}, et aucun changement
il n'offre pas : {what}
il n'a pas de script {name} ; une table [[gateways.ble.proxies]] l'installe
le robot n'accepte aucun ordre dans son mode {what}
une page ne peut pas changer la table {name}, seulement : {what}
la cl\xE9 {name} charge un programme ou un fichier ; \xE9crivez-la vous-m\xEAme
vous ne pouvez pas donner le droit {name} ; utilisez : homebot token new
aucune sauvegarde n'a d'octet {count} ; commencez \xE0 0
le changement {name} ne nomme rien
l'adresse {name} n'est plus dans le fichier ; regardez-le \xE0 nouveau
la passerelle {name} est absente : {reason}
{name} n'a pas r\xE9pondu en {count} s ; on ignore si c'est fait
refus\xE9 ({value}) : {reason}
revenu apr\xE8s {count} s, {value}
non envoy\xE9 : {reason}
contredit : {reason}
le nom de la machine est introuvable en ce moment ({what})
{name} a l'ascenseur
{value} a ferm\xE9 la connexion
{name} n'est pas connect\xE9 : {reason}
{name} n'est pas connect\xE9
{name} n'a pas r\xE9pondu en {count} s
{name} dort ; r\xE9essayez quand il sera \xE9veill\xE9
{name} est indisponible dans Home Assistant
Home Assistant n'a plus d'entit\xE9 pour {name}
{name} n'a pas de pilote ; \`homebot doctor\` nomme les inutilisables
le certificat de {name} n'est pas fiable
{what} : le serveur r\xE9pond {count}, \xE7a marchera peut-\xEAtre plus tard
le serveur r\xE9pond {count}
il demande un mot de passe (statut {count})
il refuse homebot avec ce mot de passe (statut {count})
ne prend pas : {value}
prend un nombre de {least} \xE0 {most}
il n'a pas ce r\xE9glage ; il prend {list}
{name} n'a mesur\xE9 aucun changement
il n'y a pas d'appareil {name}
personne n'est dans {room}
{name} n'a jamais d\xE9tect\xE9 personne ; passez devant une fois
{name} n'est entendu que depuis {count} s
{reason}, et l'acc\xE8s ne permet que {what} ; ajoutez {right} dans la table [{table}] de homebot.toml
{reason}, et l'acc\xE8s ne permet que {what}
un tel appareil demande un droit qui le nomme ({reason})
{what}, ce qui prime encore {count} s
{value}, selon un ancien message : injoignable maintenant
{value}, selon un ancien message : vu il y a {age}
{value}, selon un message gard\xE9 : il n'a encore rien dit lui-m\xEAme
{name} s'appelle maintenant {what}
{name} est rejet\xE9 et ne reviendra pas
{name} ne tourne pas : {reason}
une routine ou app {name} existe d\xE9j\xE0 ; choisissez un autre nom, ou modifiez-la
{name} est dans la configuration ; changez-le l\xE0, puis : {what}
rien \xE0 annuler : {name} n'a pas \xE9t\xE9 appliqu\xE9e, ou l'a d\xE9j\xE0 \xE9t\xE9
plus rien de {name} n'est \xE0 r\xE9tablir
la sc\xE8ne {name} existe d\xE9j\xE0
{name} n'est pas dans la maison en ce moment ; laissez-le tel quel, ou enlevez-le
il peut y en avoir {count} ; enlevez-en un d'abord
{name} a chang\xE9 entre-temps ; regardez-le, et r\xE9essayez
{name} existe d\xE9j\xE0 ; supprimez-le, ou donnez un autre nom \xE0 la passerelle
{reason}, donc seulement par son nom : {what}
il n'est pas associ\xE9 : {what}
{name} n'est pas associ\xE9 \xE0 homebot
le dernier rechargement a \xE9t\xE9 refus\xE9 : {reason}
pas de r\xE9ponse en {count} s
trop de codes sans effet connu de {issuer}
pas tant que {condition}, et l'\xE9tat de {name} est inconnu : {reason}
il y a quelqu'un dans {room} : {name} \xE9tait actif il y a {count} s, et aucune porte ne s'est ouverte depuis
il y a peut-\xEAtre quelqu'un dans {room} : {name} a chang\xE9 il y a {count} s, sans qu'une commande l'explique
{name} demande un droit qui le nomme ({reason}), et {issuer} n'en a pas{what}
{name} demande un droit, car {reason}, et {issuer} n'en a pas{what}
il n'est pas sur la liste des appareils sans danger ({what})
maintenu \xE0 {value} par {holder} jusqu'\xE0 sa lib\xE9ration
maintenu \xE0 {value} par {holder} encore {count} s
maintenu par {holder} jusqu'\xE0 sa lib\xE9ration : {value}
maintenu par {holder} encore {count} s : {value}
{name} a dit non
personne n'a r\xE9pondu en {count} s : cela se fait sur la page ou avec \`homebot answer\`
il est {time}, et c'est le calme de {start} \xE0 {end}
il y a quelqu'un dans {room} : {what}
il y avait quelqu'un dans {room} il y a {count} s : {what}
il y a peut-\xEAtre quelqu'un dans {room} : {what}
on ne sait pas s'il y a quelqu'un dans {room} : {reason}
{name} a bascul\xE9 {count} fois en {span} s
pas tant que {condition} : {what}
le membre {name} refuse : {reason}
{issuer} ne peut pas commander {name}, seulement : {what}
{issuer} ne peut pas commander {name} : {reason}
aucun appareil n'est joignable : {reason}
{name} est injoignable : {reason}
{name} n'est pas sur le r\xE9seau en ce moment
la connexion \xE0 {name} a \xE9t\xE9 perdue
type : {value}
type : {value}
il se nomme {name}
son unit\xE9 est {name}
il chauffe jusqu'\xE0 {count} \xB0C
\xE0 c\xF4t\xE9 d'une autre partie : {reason}
le nom {name} dit {what}
le mod\xE8le {name} dit {what}
la passerelle {name} ne dit pas son \xE9tat
probl\xE8me de {name}
abandonn\xE9 par {name}
d\xE9faillances dans {name} depuis le d\xE9marrage
compt\xE9 par {name} dans les dix derni\xE8res minutes
compt\xE9 par {name} depuis le d\xE9marrage
en quarantaine chez {name}, qui ne lit qu'une partie de leurs messages
note sur {name}
passerelle {name} : {value}, envoie des commandes
passerelle {name} : {value}, observe seulement : {reason}
passerelle {name} : {value}, observe seulement
passerelle {name} : {value} : {reason}
{reason} Apr\xE8s le red\xE9marrage de homebot : {keys}
Le fichier est inchang\xE9 : {reason}
{count} appareils attendent une autorisation et ne re\xE7oivent rien avant : {list}
1 appareil attend une autorisation et ne re\xE7oit rien avant : {list}
le dernier message n'est pas parti : {reason}
vu il y a {age}
fait : {what}
retenu : pas {what}
{what} a \xE9chou\xE9 : {reason}
{value} ({count} %)
{value}, depuis {age}
{name} n'est pas sans danger ({reason}), et {value} ; approuvez-le avec {what}
la r\xE8gle a \xE9chou\xE9 : {what}
{count} commandes attendent leur r\xE9sultat
sa passerelle {name} est {value} : {reason}
sa passerelle {name} est {value}
{name} n'a pas r\xE9pondu en {count} s : {what}
personne n'\xE9coute {what}
son bouton n'a pas \xE9t\xE9 press\xE9 en {count} s ; pressez-le et r\xE9essayez
{name} n'a pas \xE9t\xE9 associ\xE9 : {reason}
{what} a \xE9t\xE9 refus\xE9 : {reason}
{name} n'a pas d'image
{id} : {name} n'a vu aucun effet de sa derni\xE8re commande ; apr\xE8s r\xE9paration, \`homebot trust {what}\`
{name} ({reason})
accepte : {what}
cette partie accepte : {list}
aucun de ses modes : {list}
l'appareil r\xE9pond : {what}
{name} est d\xE9j\xE0 associ\xE9 \xE0 homebot
{name} d\xE9pend du pont {what}, associ\xE9 en entier
{reason} ; r\xE9essayez dans {count} s
d'ici, seulement : {value}
la pi\xE8ce {name} existe d\xE9j\xE0
{name} s'appelle d\xE9j\xE0 ainsi
{name} est associ\xE9 \xE0 un autre syst\xE8me ; dissociez-le ou r\xE9initialisez-le, puis {what}
{name} est supprim\xE9
{name} est modifi\xE9
{name} est ajout\xE9
{name} a dit oui
{name} ne r\xE9pond pas
{name} n'a pas r\xE9pondu
{name} n'accepte aucune commande que homebot conna\xEEt
{count} appareils correspondent \xE0 {name} ; au plus {most} \xE0 la fois
{what} n'a pas \xE9t\xE9 envoy\xE9 \xE0 {name} : {reason}
{what} a \xE9t\xE9 envoy\xE9 \xE0 {name} : {reason}
{what} de {name} : {reason}
{name} a d\xE9j\xE0 {what}
{name} n'a pas de partie
{name} est injoignable par TLS : {reason}
{count} proxys Bluetooth sont d\xE9j\xE0 connect\xE9s
{name} met plus de {count} s pour r\xE9pondre
{name} n'est connu d'aucun point
{name} n'a pas d'adresse HTTP
{name} n'a pas d'adresse
{name} ne r\xE9pond \xE0 aucune demande
{name} n'accepte aucun message
{name} a mis fin aux \xE9v\xE9nements
{name} ne peut \xEAtre annonc\xE9 comme {what} : {reason}
{name} : {count} commandes attendent d\xE9j\xE0 {what}
{name} ne peut \xEAtre ouvert : {reason} ; {what}
{name} ne peut \xEAtre ouvert : {reason}
{name} n'a pas \xE9t\xE9 r\xE9gl\xE9 : {reason}
{name} s'associe par le code inscrit dessus : {what}
{name} est d\xE9j\xE0 mis en service
{name} d\xE9pend du pont {what} ({id}) ; seul le pont peut \xEAtre retir\xE9
{name} ne r\xE9pond pas au serveur Matter
{name} ne s'est pas encore d\xE9crit
{what} de {name} ne peut \xEAtre r\xE9gl\xE9
{name} ne peut \xEAtre \xE9crit : {reason}
{name} ne peut \xEAtre mis de c\xF4t\xE9 : {reason}
{name} n'est pas ouvert
{name} ne peut \xEAtre copi\xE9 : {reason}
{name} ne peut \xEAtre recr\xE9\xE9 : {reason}
{name} de {what} ne peut avoir son propre fichier
{name} = {what} n'est pas une valeur TOML ; un texte veut des guillemets
{name} ne peut \xEAtre un nom : donnez jusqu'\xE0 {count} caract\xE8res imprimables
{name} ne marche pas ({what}) : {reason}`;export{n as reasons,e as texts};
