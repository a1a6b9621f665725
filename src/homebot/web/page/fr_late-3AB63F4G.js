var e=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 3k4 il 1ow 109 1qe 44w 3z id 7yk 5qv 1nc 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 3gk 1 1qf 390 312 1on 84 93w 56y 5g 1sr 1 7lm 7i6 nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt jf 6vj 1al 2a4 71r 64j 38b 3b2 43 1z3 17l 6k gl7 58 1im 2ep 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 557 8li 233 5kk 463 101 1lp 2vn 2u5 41m 11l 58d 23v o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 5ks hh 4e rd 1ei 1c3 h6 6n 6tg 19i ij 243 us ss 1ek md 4ku 353 2h1 z1 4ys 6nt 2xg 9nj 88c ji f2 gv eri py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 9ib 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 6lu 2vv y2 7xl 1cg d4j 2hy 1yk kc vp 8i9 3mx 70 1cw xs 507 24o 1n8 1lj 1wx 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 7am 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 3jn hyb ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 1to 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np 7db 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1oh 3ne 18n 3yv 2la 16 2sf 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 219 4be 2r2 3uo 39k 269 oi 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 2b6 7o 6ev 3ei 2xk 3ug 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3r9 1qr el rb 2ih 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 4dd 6i4 811 2kh 57s 1k9 1cg 2eh 38c 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 8v0 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 3pq 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2te 5x2 7nh i2 9h8 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 2fr 3 5tk 6u b34 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 3u8 rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 3q3 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 1xq a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe aor 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
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
a tourn\xE9
brut
\xE9tiquette
continuer sans jeton
{issuer} a demand\xE9 {values}
lecteur vid\xE9o
PM10
vous l'avez fait {time} avant
envoi \u2026
Historique
les associations avec Apple Home
un programme inconnu
lui donner le droit
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
pr\xE9sence
les derni\xE8res 24 heures
Un serveur sur cet ordinateur
titre
connexion
Un ventilateur tourne tant que la salle de bain est humide.
retours perdus
red\xE9marrer homebot
Il n'y a pas (ou plus) d'appareil {name}.
\xE0 la main ou tout seul
homebot why APPAREIL montre les signalements
homebot tourne \xE0 l'essai et n'envoie rien
Utilisateur
il a chang\xE9 depuis ; regardez-le de nouveau
envoy\xE9 en un seul message au groupe {name}
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
aucun programme n'y r\xE9pond : d\xE9marre-le, ou corrige l'adresse
d\xE9tecteur de fum\xE9e ou de CO
d\xE9tecteur de gel
il a chang\xE9 depuis votre accord
{what} au fil du temps, {count} points
Rien ne s'est encore pass\xE9.
De la lumi\xE8re tant que quelqu'un bouge et qu'il fait sombre ; une lampe d\xE9j\xE0 allum\xE9e, ou que l'on commande entre-temps, reste comme elle est.
Qui la consomme
indisponible
Un jeton donne ses droits \xE0 cette page : le v\xF4tre est la ligne dans owner.token, dans le dossier de donn\xE9es de homebot. Pour une tablette, cr\xE9ez-en un avec :
Plus frais quand personne n'est l\xE0, chaud d\xE8s le premier qui rentre.
, par une personne
Comme ntfy://TOPIC ou mailto://USER:PASSWORD@HOST ; appriseit.com les cite tous.
la connexion a \xE9t\xE9 ferm\xE9e
ne rien faire
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
aucun appareil trouv\xE9 avec ce code ; est-il pr\xEAt \xE0 l'association, sur ce r\xE9seau, et pas d\xE9j\xE0 associ\xE9 ?
Associ\xE9 \xE0 {count} contr\xF4leurs.
permis
utiliser {name}
En attente de votre accord
sabotage
Personnes
c'est contradictoire ; n'en donne qu'un
Ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
plus t\xF4t
, car la sc\xE8ne {scene} a \xE9t\xE9 appliqu\xE9e
enregistr\xE9
, car la sc\xE8ne {scene} a \xE9t\xE9 annul\xE9e
depuis {time}
le nom de la machine est inconnu : corrige l'adresse
Latitude
la masquer dans la maison
observe : {name}
Les lignes apparaissent ici \xE0 mesure.
commence par {view}
Salon
corriger ou retirer l'\xE9metteur
Il faut : {what}
Ses appareils apparaissent ici.
Aucun appareil n'indique encore de temp\xE9rature.
L'aspirateur nettoie une fois par jour quand tout le monde est parti.
capteur de pluie
Un chauffage se repose tant que sa fen\xEAtre est ouverte.
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
Cet \xE9cran
Cave
il est associ\xE9 ailleurs ; retirez-le l\xE0-bas, ou r\xE9initialisez-le
Il peut
perdus pour des absents
rejet\xE9s
Baiss\xE9 aux deux tiers tant qu'il fait chaud.
{least} \xE0 {most}
Un mot quand une fen\xEAtre reste ouverte et qu'il fait froid dehors.
Un mot quand on consomme beaucoup un moment.
au repos
Chargement du plan \u2026
fermez-le
mode
Portes et fen\xEAtres
joint par
c'est dans la configuration ; change [places] l\xE0
, \xE0 cause de {what}
Autres commandes
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
demandes abandonn\xE9es
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
Salle de bain
le broker
Un mot quand un cong\xE9lateur est trop chaud un moment.
Masqu\xE9s
est ouvert
Ceci est maintenant dans homebot.toml :
Boucle d'\xE9v\xE9nements
d\xE9tecteur
Entr\xE9e
approuver {name}
trop de codes faux ; d\xE9branchez-le un instant
porte peut-\xEAtre ouverte
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
lancer maintenant
Le code qu'affiche homebot run laisse entrer un premier \xE9cran.
\xE9nergie inject\xE9e
connexions refus\xE9es au mot de passe
personne n'a \xE9t\xE9 pr\xE9venu ; [notify] et le journal disent pourquoi
\xC9crans
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
homebot show APPAREIL
dossier des donn\xE9es
Sept jours
traceur
\xE0 la main
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
vers la maison
balayage horizontal
Ouvrez ceci une fois sur l'\xE9cran ; ce n'est affich\xE9 que maintenant :
Le lieu donne le lever et le coucher du soleil ; il reste ici.
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
Aucune app ne tourne.
Chargement des routines \u2026
attendre une minute, puis voir le journal de homebot
plusieurs noms pour un identifiant : peut-\xEAtre plusieurs appareils
foyer
\xE9tage
l'appareil ne peut qu'\xEAtre \xE9teint, comme une plaque par s\xE9curit\xE9
pas encore connect\xE9
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
ensuite
en retard de
contest\xE9
{name} peut commander les appareils
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
regarder
perdus
r\xE9ponses
Appuyez sur le bouton : encore {count} s
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
annonces`,n=`gateway {name} is away: {reason}
service {name} did not answer within {count} s; whether it acted is unknown
refused ({value}): {reason}
changed back after {count} s, {value}
not sent: {reason}
contradicted: {reason}
the host name cannot be looked up now ({what})
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
le gateway {name} est absent : {reason}
{name} n'a pas r\xE9pondu en {count} s ; on ignore si c'est fait
refus\xE9 ({value}) : {reason}
revenu apr\xE8s {count} s, {value}
non envoy\xE9 : {reason}
contredit : {reason}
le nom de la machine est introuvable en ce moment ({what})
{value} a ferm\xE9 la connexion
{name} n'est pas connect\xE9 : {reason}
{name} n'est pas connect\xE9
{name} n'a pas r\xE9pondu en {count} s
{name} dort ; r\xE9essaie quand il sera \xE9veill\xE9
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
{name} n'a jamais d\xE9tect\xE9 personne ; passe devant une fois
{name} n'est entendu que depuis {count} s
{reason}, et l'acc\xE8s ne permet que {what} ; ajoute {right} dans la table [{table}] de homebot.toml
{reason}, et l'acc\xE8s ne permet que {what}
un tel appareil demande un droit qui le nomme ({reason})
{what}, ce qui prime encore {count} s
{value}, selon un ancien message : injoignable maintenant
{value}, selon un ancien message : vu il y a {age}
{value}, selon un message gard\xE9 : il n'a encore rien dit lui-m\xEAme
{name} s'appelle maintenant {what}
{name} est rejet\xE9 et ne reviendra pas
{name} ne tourne pas : {reason}
une routine ou app {name} existe d\xE9j\xE0 ; choisis un autre nom, ou modifie-la
{name} est dans la configuration ; change-le l\xE0, puis : {what}
rien \xE0 annuler : {name} n'a pas \xE9t\xE9 appliqu\xE9e, ou l'a d\xE9j\xE0 \xE9t\xE9
plus rien de {name} n'est \xE0 r\xE9tablir
la sc\xE8ne {name} existe d\xE9j\xE0
{name} n'est pas dans la maison en ce moment ; laisse-le tel quel, ou enl\xE8ve-le
il peut y en avoir {count} ; enl\xE8ves-en un d'abord
{name} a chang\xE9 entre-temps ; regarde-le, et r\xE9essaie
{name} existe d\xE9j\xE0 ; supprime-le, ou donne un autre nom au gateway
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
{name} n'a pas r\xE9pondu`;export{n as reasons,e as texts};
