var n=`1c 1 aqg 2oh gn9 4 xj m4 7w 3a 2hc xg 1jt mb 6u2 1c7 2dr fsj 1du 3g5 35h 25q 3f8 58 8i6 9hb 12yl 4lo 18i 1q 320 h96 ir 5bl 1a2 1qb 57t 8b 1er d3x i46 bkg tx 8fp 1p5 75 g82 1zw 1i3 1vc a3g dq4 1mj 18i 50n cd 56y e9 3th p0 37a 38 qv dfu 41 8qh k0 1nu 5vw 1x8 41q 300 iiz 4 4z 4e7 3ua 3tz f8 7ep 24m 3ic 4w2 iy 1aw 18g k04 4k7 6m8 b4 3os 142 41v 1k8 lr 1wu az0 dmb yq1 8a7 ft 4mz 3i2 mte wv 1u 6b2 7ju j57 1r8 2cy 21t 8w9 u8 9n6 3h8 5uq 4nf m7 ma 9id 1ml oi 5ph 2bz 1pf 3zx or 33i 1 5vx yv 5e a5i 48v no 4y8 6e8 2y0 xz m2r 15w 9oh 1jt 1j6 77x 119 5w0 qo 2l ad8 1lw 2b3 of 1x5 ev6 2hl 7g9 598 ij es 9 2sc 2 agn 1r6 6t6 e 2pa 51y aux b0y 1v3 2zr 7oc d6 7wx 6i6 4oe fak 2e8 115 4v 3qy 3 1 2h6 1rq 10o ch8 70i 160 2bz 6pq jb 1qy 1fm cdm 1t7 8u9 1f 34e 2b4 j7 s1 2y5 5bj 4jv ob 4b1 5g9 3q9 d61 77y 2qs up7 c i2a 7d4 4sy ftn 5b8 23v 63h 9w3 how 3ot 6e5 962 5cb 5k8 6eu 5fa 3n8 nf0 6t 2tf 3oz l9d 1m3 j9b 6cx ag4 5m9 9n 59j 1wo 18q 33d bhk yx 7sg 8c7 ty 1t 84d h0 5vx 4oy d77 2cm 4ca 2tb ctm 6ar 4wc fk2 8f8 1h0 3t 7ry bn 10j 8aj 7x 6r3 jo7 b9 26m 18g 4l8 4me 8vf 3uy um 3zq 1hw 10c cw el 42f 5fe 1bq 2hr 1br 483 hu jh 2vm 1h7 96w t3 5uz 53l 18 h6 9th aam 22w xg 1yi 1 3hw 7m6 fv 10d po 6i5 ayk h7 6t3 2cp 3xy hu1 dl0 m9 3ml eo
non
allum\xE9
* appareils
homebot est injoignable
ajouter
tout
sec
ventilateur
# est absent
gaz
\xE9teint
rouge
mouill\xE9
oui
se ferme
porte de garage
ouvrant
d\xE9connect\xE9
d\xE9branch\xE9
toilettes
temp\xE9rature
bleu
Aucun appareil n'est encore connu. Ils apparaissent ici d\xE8s qu'ils sont trouv\xE9s.
non connect\xE9
d\xE9marrer
libre
s'ouvre
couloir
chaleur
ouvrir
\xE0 la maison
droits
# est \xE0 la maison
lave-vaisselle
d\xE9sarmement
injoignable
arm\xE9 partiel
afficher * masqu\xE9s
pi\xE8ces
salon
nom
ex\xE9cuter
consigne de refroidissement
sens
allumer
appareil
code pour $
lames
d\xE9verrouill\xE9
en mouvement
occup\xE9
Commander quand m\xEAme ?
texte
inclinaison
retour \xE0 la base
monoxyde de carbone
Portes, capteurs et autres
fermer
lumi\xE8res de ~
effet lumineux
lecture
Graphe
je l'ai vu
armement
tout est ferm\xE9
annul\xE9
chauffe
se d\xE9verrouille
d\xE9verrouiller
pas de chaleur
au contenu
store banne
code
frais
appuyer
refroidissement
\xE0 regarder seulement
aspirateur
chaud et froid
allumer
rideau
pas de gel
ventilation
pas de bruit
humidit\xE9
erreur
pas de sabotage
plafond
ic\xF4ne
au repos
avant
verrouill\xE9
d\xE9clench\xE9
Pi\xE8ce
plus tard
tondeuse
fen\xEAtre
mise en tampon
ouvert
son coup\xE9
R\xE9cemment
remplac\xE9 par une commande plus r\xE9cente
ferm\xE9
tond
Sans pi\xE8ce
fum\xE9e
pas de probl\xE8me
vues
dernier \xE9tat connu
* lumi\xE8res
pas en charge
supprim\xE9
S\xE9curit\xE9
connexion \u2026
Ce code n'est plus valable : homebot en affiche un autre \xE0 son d\xE9marrage.
pas de vibration
lecture
pas de r\xE9ponse en >
vert
lire
< ouvert
chauffage
Cette vue n'existe pas.
vibration
arm\xE9, absent
plus fort
enfants
bureau
fait
porte
pile faible
orange
Plus
effacer
pas de courant
contact
lumi\xE8re
son activ\xE9
non approuv\xE9
refus\xE9
Recherche
inconnu
chambre
marche/arr\xEAt
dehors
oscillation
bureau
\xE9teindre
lieu
pas maintenant
caf\xE9
consigne de chauffage
frigo
arr\xEAt
store enrouleur
Maintenir : $
# d\xE9verrouill\xE9
cuisine
rose
Aucun appareil n'a ces mots dans son nom, son type ou sa pi\xE8ce.
plan
prise
pompe
bouton
consigne d'humidit\xE9
D\xE9bits
store
appui
tous \xE0 la maison
r\xE9sum\xE9
mesure
pile
pile <
luminosit\xE9
maintenant <
pr\xE9sence
effet
\xE0 sa base
Accueil
Il manque \xE0 cet \xE9cran le droit {right}. Le propri\xE9taire lui donne un jeton avec plus de droits : Syst\xE8me, Configurer, \xC9crans.
Journal
confirm\xE9 apr\xE8s >
mettre en pause
p\xE9rim\xE9
d\xE9marrer
\xE9tat
immobile
boutons, r\xE9glages et mises \xE0 jour : *
bandeau
personne
consigne <
silencieux
choix
arr\xEAt\xE9
modifier
volet
arr\xEAter
absent
connect\xE9
couleur
pile bonne
1 lumi\xE8re
en charge
Il n'y a aucun appareil dans une pi\xE8ce ~.
nettoie
refroidit
sc\xE8ne
nombre
tout allumer
lave-linge
Lumi\xE8res
arm\xE9, pr\xE9sent
contredit : {saw}
* chiffres
l'appareil a \xE9t\xE9 retir\xE9
question
sir\xE8ne
# ouvert
tension
lampe
mouvement
\xE9teindre
quelqu'un est absent
Chargement des appareils \u2026
bruit
neutre
chaud
d\xE9sarm\xE9
Aucun appareil pour l'instant : configurez votre maison.
\xE0 jour
bouton
cam\xE9ra
Configurer
annuler #
mise \xE0 jour disponible
arri\xE8re
blanc
salle de bains
volume
Configuration
gel
lampadaire
se verrouille
jour
verrouiller
sabotage
lampe
moins
serrure
arm\xE9, nuit
n'oscille pas
moins fort
dangereux
en pause
supprimer # d\xE9finitivement
r\xE9cent
pas de gaz
refus\xE9 ({policy}) : &
cave
thermostat
pluie
pi\xE8ce
plus de #
arm\xE9, vacances
jaune
Personne n'en sera plus averti.
* allum\xE9es
branch\xE9
violet
bloqu\xE9
PM2,5
{state} depuis >
tout \xE9teindre
refroidi \xE0 <
supprimer
demandes
annuler
bougie
courant
probl\xE8me
pas de fum\xE9e
d\xE9sarmer
\xE9nergie
Routines
nouvelle sc\xE8ne
pas de lumi\xE8re
enceinte
\xE0 la maison
homebot est injoignable depuis > : il red\xE9marre peut-\xEAtre.
Appuyer encore : $
d\xE9shumidification
portail
courant
date d'avant : l'appareil n'a rien signal\xE9 depuis le d\xE9marrage de homebot.
revenu apr\xE8s >
pas de monoxyde de carbone
Pi\xE8ces
Plan
mettre en pause
alarme
Syst\xE8me
salle \xE0 manger
Climat
Favoris
sc\xE8nes
position
pas de pluie
* appareil
garage
jardin
valeur
vanne
\xC9nergie
injoignable
plus
revient
r\xE9servation
intensit\xE9
en attente
s\xE9curit\xE9
puissance
joignable
c'\xE9tait d\xE9j\xE0 ainsi
automatique
s\xFBr
lecture
interrupteur
zone`;export{n as texts};
