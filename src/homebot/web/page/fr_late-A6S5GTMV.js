var e=`24e 5rm 1ts 2b7 5w 1j0 y4 rn 1pz 40 2gq 5up d1 1c9 25s 105 nh 10b w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 93w 56y 5g 1sr 1 62v 1ir 1gj av 5qs nf 23f 4mf hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 ot 1pj 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 8q 1qy 43 1z3 17l 6k kt 9zn 53l x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 2se 16a 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 2pb 3tv 18j sp 9b 1l2 q0 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv 4z0 14d 72h 1lo py 29q 2os 38b 18q 1e6 4be 66n 9jc 53k e0 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 4l 17l 9nf 38l sw 4ab 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 36 2es 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 3d1 5bi fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 159 1t0 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 3i8 ir bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu 8zc 7z5 ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 1o2 yq 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 2nz zf g2 sl 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1ls 9o 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 60 19n 6z ow 1y4 1kw 89 1qr el rb 1vc n5 39k k2 1s5 1xu 5y3 1hy 4l2 bp1 pi lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 5e8 2mt 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o 3uo 6f2 jx 4dl 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 1mc 179 4d k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 7 230 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 5j 1ih 1s5 w0 1ax cx 1nh ih 2hh 18m 6h sj 17y al q7 3x1 1fo 2wz 1df 6qm 5c1 k9 1dh 6l a1n h ca 13y 10c 4rg 35s 25z rh z0 123 ru 2aw 2kn 3j5 6n 29h 1d6 3p8 1yg 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
plante
le code est faux
il a l'\xE9tiquette always_ask
mis en service, mais ses attributs n'ont pu \xEAtre lus
le texte
\xE9checs du journal
Garage
il ne prend pas de commandes, il signale seulement
teinte (0 \xE0 360) et saturation (0 \xE0 100), comme 0,100 pour rouge ou 240,50 pour bleu p\xE2le
Jardin
\xE9tats perdus
recommencer
# est t\xE9l\xE9charg\xE9e ({size} ko).
Il n'a encore signal\xE9 aucun changement.
d\xE9bitm\xE8tre
une autre cl\xE9
seule une app ou routine peut en avoir un, par \`act\`
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
Aucune des * derni\xE8res entr\xE9es n'a ces mots.
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
vous l'avez fait > avant
envoi \u2026
Historique
les associations avec Apple Home
un programme inconnu
le serveur Matter a \xE9t\xE9 arr\xEAt\xE9
lui donner le droit
aucune sc\xE8ne n'en garde
l'appareil r\xE9pond par une erreur
un code Matter a 11 ou 21 chiffres, ou est un QR code qui commence par MT:
faire
la pi\xE8ce de l'appareil
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
pas de D-Bus ; sous Linux, bluetoothd et le bus syst\xE8me doivent tourner
Elle est en cours \u2026
Il a chang\xE9 \xE0 >.
par {issuer}
Une lumi\xE8re douce pour le chemin, la nuit.
favori
pile, courant, port\xE9e ?
Non compris \xE0 > :
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
l'historique n'a pas commenc\xE9, ou est inutilisable ; \`homebot doctor\` dit pourquoi
red\xE9marrer homebot
Il n'y a pas (ou plus) d'appareil #.
\xE0 la main ou tout seul
homebot why APPAREIL montre les signalements
homebot tourne \xE0 l'essai et n'envoie rien
son effet ne dure pas
m\xE9dia
son mod\xE8le ne donne rien pour cela
Utilisateur
il a chang\xE9 depuis ; regardez-le de nouveau
envoy\xE9 en un seul message au groupe #
la connexion \xE0 Home Assistant est perdue
finit
Commandes
compteur
notifications perdues
annuler
signale du monoxyde de carbone
aucune voie n'y m\xE8ne les commandes
cela rend la maison plus s\xFBre
a signal\xE9 {values}
il est silencieux depuis trop longtemps
approbation
Son bo\xEEtier est-il ouvert, ou est-il d\xE9croch\xE9 du mur ?
en attente
apr\xE8s un code faux, il veut une pause ; r\xE9essayez plus tard
plan de * pi\xE8ce
aucun programme n'y r\xE9pond : d\xE9marrez-le, ou corrigez l'adresse
d\xE9tecteur de fum\xE9e ou de CO
d\xE9tecteur de gel
ce n'est pas un pont Hue ; associez le pont dont il d\xE9pend
il a chang\xE9 depuis votre accord
$ au fil du temps, * points
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
il vient d'annoncer d'autres sujets, peut-\xEAtre ceux d'un autre appareil ; r\xE9essayez
climatiseur
fragments perdus
Les nouvelles passerelles commencent au prochain d\xE9marrage de homebot.
il attend, une minute au plus, les appareils d'avant ; r\xE9essayez
son pont ne l'atteint pas
capteur d'humidit\xE9
Les alertes et les questions vont par ces adresses aux t\xE9l\xE9phones, aux messageries et au courrier.
la commande ne tourne pas ; elle red\xE9marre d'elle-m\xEAme, voir Syst\xE8me
commandes \xE9chou\xE9es
\u2026 et * autres
il n'y a plus d'\xE9v\xE9nements
aucun appareil trouv\xE9 avec ce code ; est-il pr\xEAt \xE0 l'association, sur ce r\xE9seau, et pas d\xE9j\xE0 associ\xE9 ?
Associ\xE9 \xE0 * contr\xF4leurs.
permis
accepte des nombres de 0 \xE0 360, 0 \xE0 100
utiliser #
En attente de votre accord
sabotage
Personnes
c'est contradictoire ; n'en donnez qu'un
Ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
plus t\xF4t
, car la sc\xE8ne {scene} a \xE9t\xE9 appliqu\xE9e
enregistr\xE9
, car la sc\xE8ne {scene} a \xE9t\xE9 annul\xE9e
depuis >
n'accepte que true
le nom de la machine est inconnu : corrigez l'adresse
Latitude
la masquer dans la maison
observe : #
Les lignes apparaissent ici \xE0 mesure.
commence par {view}
Salon
corriger ou retirer l'\xE9metteur
accepte une date avec fuseau horaire
Il faut : $
les \xE9tiquettes n'acceptent pas de commandes
Ses appareils apparaissent ici.
Aucun appareil n'indique encore de temp\xE9rature.
L'aspirateur nettoie une fois par jour quand tout le monde est parti.
capteur de pluie
Un chauffage se repose tant que sa fen\xEAtre est ouverte.
\`homebot find\` montre ce qui va
donnez password_file ou password_env dans [gateways.mdns.drivers.shelly]
n'en accepte pas
derni\xE8re version
mod\xE8le
if : tout ce qui doit alors \xEAtre vrai
messages perdus
dedans
heure du coucher
valeurs
messages non conserv\xE9s
le client #
biblioth\xE8que manquante
c'\xE9tait trop long
humidit\xE9 du sol
chaque \xE9tape
Cette image n'est plus r\xE9cente.
annonces : octets en m\xE9moire
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
image de #
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
Aucun appareil de cette maison ne convient : $
il refuse le mot de passe de password_file ou password_env dans [gateways.mdns.drivers.shelly]
suivant
trouv\xE9s, et pas encore utilis\xE9s
il est occup\xE9
heures et la maison
graphe
rien n'en est connu qu'une sc\xE8ne pourrait r\xE9tablir
Cet \xE9cran
Cave
il est associ\xE9 ailleurs ; retirez-le l\xE0-bas, ou r\xE9initialisez-le
un pont n'a pas de code : appuyez sur son bouton
Il peut
perdus pour des absents
rejet\xE9s
l'adresse d'un flux, comme une radio
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
, \xE0 cause de $
Autres commandes
il redirige trop souvent
Nom, pi\xE8ce et \xE9tiquettes
il n'a pas r\xE9pondu \xE0 temps
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
un autre mot de passe
Nom
autre
Plus frais la nuit.
Un mot quand une plante a soif.
nommez un appareil, ou cherchez comme 'light in hall'
propos\xE9e par #
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
sans donner de raison
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
un nombre fini
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
cette question n'existe plus ; \`homebot answer\` liste les autres
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
surtout #
inconnu : {names}
inoffensif
coupez l'eau
le journal a chacune avec sa trace : la signaler ou la corriger
aucune route vers cette machine
ce n'est pas un proxy Bluetooth ; ajoutez "bluetooth_proxy:" \xE0 sa configuration ESPHome
Salle de bain
recr\xE9\xE9
le broker
seule une personne r\xE9pond, sur la page
Un mot quand un cong\xE9lateur est trop chaud un moment.
rien n'y a \xE9t\xE9 r\xE9uni
Masqu\xE9s
est ouvert
Ceci est maintenant dans homebot.toml :
il n'a pas d'ordre \xE0 poursuivre ; donnez-lui une destination
Boucle d'\xE9v\xE9nements
d\xE9tecteur
Entr\xE9e
approuver #
trop de codes faux ; d\xE9branchez-le un instant
la porte est peut-\xEAtre ouverte
verrouillage
Sans compteur propre
Tout va bien. \xC0 noter :
Messages
True ou False
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
aucune annonce valable depuis le d\xE9marrage de cette passerelle ; red\xE9marrez-le ou son pont, ou attendez
il n'y a rien \xE0 annuler, ou le fichier a chang\xE9 depuis
recherche \u2026
Son dernier \xE9v\xE9nement, qui n'est pas un \xE9tat :
un mot de passe seul irait en clair \xE0 qui se nomme ainsi : ajoutez "api: encryption:" \xE0 sa configuration ESPHome et donnez key_file, ou son adresse IP fixe comme allow_plaintext_at dans [gateways.mdns.drivers.esphome.devices.NAME]
c'est fait une fois, et ne dure pas
vers la maison
balayage horizontal
Ouvrez ceci une fois sur l'\xE9cran ; ce n'est affich\xE9 que maintenant :
Le lieu donne le lever et le coucher du soleil ; il reste ici.
le robot n'a pas encore dit son \xE9tat
pr\xE9r\xE9glage
sa m\xE9moire est pleine
aucune adresse
il d\xE9sarme l'alarme
capteur
prendre les valeurs actuelles
Une lampe est allum\xE9e du cr\xE9puscule au coucher tant que quelqu'un est l\xE0.
topics r\xE9serv\xE9s
le pont r\xE9pond quelque chose d'inconnu
appareils refus\xE9s
# est associ\xE9.
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
donnez \xE0 homebot un dossier accessible (HOMEBOT_DATA), ou lancez-le avec --ephemeral
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
vous l'avez fait > plus tard
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
envoy\xE9 en un seul message \xE0 la sc\xE8ne #
, par un autre programme
rien n'a encore \xE9t\xE9 chang\xE9
mode du ventilateur
Tout va bien.
accepte un nombre que son format peut \xE9crire
Le chauffage marche fen\xEAtre ouverte
ce n'est pas un JPEG, PNG, GIF ou WebP de 2 Mio au plus
il y a >
perdus, trop grands
corriger l'appareil ou son annonce
mode
vous, par $
si elle d\xE9marre alors qu'elle tourne
Appareils
Omis, car secrets : {files}
envoyer un message d'essai
Rien n'est encore compt\xE9.
on ou off
homebot ne peut pas red\xE9marrer seul ici ; relancez-le
aucune route vers ce r\xE9seau
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
# peut commander les appareils
donnez-en une, comme level 40
pression
chaque fois
d\xE9tecteur de fuite
vanne d'eau
matin
re\xE7us
bluetoothd ne tourne pas
un mot de passe
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
Appuyez sur le bouton : encore * s
CoAP n'a pas cette m\xE9thode
R\xE9cemment ici
do : ses \xE9tapes, une ligne chacune
un texte
plan de * pi\xE8ces
sans pi\xE8ce
en m\xEAme temps
pile en charge
De la lumi\xE8re et un mot quand il y a de l'eau o\xF9 il n'en faut pas.
supprimer #
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
donnez la cl\xE9 que sa configuration ESPHome a sous "api: encryption:" comme key_file, ou aucune
pi\xE8ce
{issuer} a \xE9t\xE9 refus\xE9 : &
Sujet
homebot sait qui est \xE0 la maison par les t\xE9l\xE9phones du r\xE9seau et par les traceurs.
absent
Des lampes s'allument et s'\xE9teignent le soir quand personne n'est l\xE0.
Un mot quand le lave-linge a fini.
sa convention a \xE9chou\xE9
abaiss\xE9
, par l'appareil ou une personne
depuis le d\xE9marrage de cette passerelle il n'a pas dit ce qu'il sait faire ; s'il dort, r\xE9veillez-le
le garder dans ce navigateur
notifications \xE9chou\xE9es
un autre chiffrement
pile, courant, port\xE9e ? S'il est parti pour de bon : homebot forget DEVICE
d\xE9shumidifie
Bureau
Files et pertes
Rien de mesur\xE9 ne fonctionne.
Ce que vous changez ici, chaque \xE9cran le montre.
ses lames ne font que s'ouvrir (100) et se fermer (0)
abandonn\xE9s, trop nombreux
un nombre
ce homebot n'a pas de routines
sombre
Sans TLS, un navigateur n'installe pas d'application : tls = true dans [door].
version
connexions \xE9chou\xE9es
robot aspirateur
Couleurs
un chiffrement
valeurs illisibles
une pression sur son bouton
copi\xE9
se d\xE9connecter
tout seul
encore * s
rien
il n'y a pas d'adresse : [notify] n'en a aucune
configuration erron\xE9e
Une lampe s'\xE9claircit vingt minutes avant le lever.
l'\xE9tat de la maison
renvoy\xE9
montrer ce que permet l'accord pour #
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
annonces`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# was switched back and forth * times within {span} s$
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
the ^ # cannot be <: &
no CoAP endpoint can be opened: &
no < multicast on the interface #: &
mDNS cannot be used on #: &
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
# a bascul\xE9 * fois en {span} s$
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
^ # ne peut \xEAtre < : &
aucun point CoAP ne peut \xEAtre ouvert : &
pas de multicast < sur l'interface # : &
mDNS ne peut servir sur # : &
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
