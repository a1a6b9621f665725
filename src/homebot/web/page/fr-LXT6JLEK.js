var n=`29 1 fh 1mf 14y 5lx gd 6tu 71n 41y ss 19r acd 8e6 98l 58m g9 84r 2lt afv 6 2el 77 1q2 v8 2ca 4lj 24l fp 1c 4c3 1qf 28f 18a 6e1 2s9 i4b 5vd 6ab 227 2ej 6u f 6yl u6 5 5qc 9d7 48s lil byg 5ek 79r 6sy 8bf 17i 3lh 5t 7zt 28g 5no 7hp f2v 82u 2gg 1tq 2w2 34s 6m6 34n e8m 811 2nm 7wa 148 1js 997 2rl 9iu au1 3am wv 1fl 4xa eb 9cj z63 65z 1cs 406 12g zm 55h 5t 1hq 2n4 4v 4ie 1ft zp 222 2q 7jr ebv z7 cuh 2ku 3at adl 4jh 6uf 2lg 447 2d0 3e4 t4 lr 47l 2ns xm 9b 1 289 z1 222 12u 8zb 4te 9nk a8k i9x 11o acw 52a d87 1 5cy v6 6gs 2p0 th 9l7 75p 44x 8lb k3 144 9r 4w6 7ms 4li d4c 9er 223 542 2cd 34x il 37d 3qn 1pg mg 9c5 9mo 768 uo f3p 8gw 2cf ax anf 1kw i1d 3ku 346 716 47z 1qc 200 8 4nw 4ly 1c5 37q 3yo 4en 1jm 105 ob 1 71 2gp 5v0 1a1 6o3 1wg 1cj i6 5fo 32k 4n5 2zo 2gk eei 763 14y 4o9 zf 2h7 74i 1jw gxh 7la bmd 4xu 4x9 1ec 4r5 3qt 7cp 6in 52y 58p rw 62z 5pq 84k 2yz 3o0 f4p 5 1 6xk 7sv 1g7 640 k 3pw 142 bmc q78 36n 4o5 14z 8v4 251 6mp 43q 212 192 42a 71t 11n 1cv 4dc wf 3xe g4 dvp 7vd 7s7 23f 2lm 2h3 3xl ls 4sv 1ds 64f tk 2u gk8 33r 9gp l8v 25g 5go gjq 3o6 1gi 7pz 3ac 235 2l9 3gz zm 7o7 97j 4nr 2uz enn 18s 20q 7cx 9vq 637 23a 7r5 2xi 8gw 2pp dri j 344 34i j bxh 9c 6z6 1lg aey gsz 3lr da6 2lp 3i 3nv 1c0 mtg it 14c hx 5ic 41x 2iz 245 7ck 90o
non
allum\xE9
annul\xE9
lieu
r\xE9sum\xE9
sens
Aucun appareil pour l'instant : configurez votre maison.
tout \xE9teindre
lecture
consigne d'humidit\xE9
PM2,5
salle \xE0 manger
lire
occup\xE9
inconnu
boutons, r\xE9glages et mises \xE0 jour : *
bouton
lecture
probl\xE8me
ajouter
tout
volume
sec
ventilateur
gaz
d\xE9sarmement
\xE9teint
Maintenir : $
Syst\xE8me
rouge
mouill\xE9
oui
arr\xEAt\xE9
humidit\xE9
mettre en pause
arr\xEAter
Plan
lave-vaisselle
r\xE9servation
rose
automatique
plan
prise
R\xE9cemment
pompe
bouton
intensit\xE9
sabotage
arr\xEAt
Commander quand m\xEAme ?
ventilation
c'\xE9tait d\xE9j\xE0 ainsi
blanc
cave
modifier
arm\xE9, pr\xE9sent
pas de lumi\xE8re
date d'avant : l'appareil n'a rien signal\xE9 depuis le d\xE9marrage de homebot.
violet
choix
son coup\xE9
lames
alarme
oscillation
\xC9nergie
bloqu\xE9
dangereux
courant
pile
refroidit
d\xE9clench\xE9
pas de sabotage
Aucun appareil n'est encore connu. Ils apparaissent ici d\xE8s qu'ils sont trouv\xE9s.
Chargement des appareils \u2026
en attente
Sans pi\xE8ce
revenu apr\xE8s >
sc\xE8nes
bureau
store
n'oscille pas
silencieux
\xE9teindre
arri\xE8re
l'appareil a \xE9t\xE9 retir\xE9
nombre
confirm\xE9 apr\xE8s >
monoxyde de carbone
{state} depuis >
cuisine
afficher * masqu\xE9s
vibration
mouvement
mettre en pause
erreur
ouvert
Journal
tondeuse
lumi\xE8res de ~
libre
\xE0 la maison
pas de monoxyde de carbone
plus de #
effet
* allum\xE9es
Il manque \xE0 cet \xE9cran le droit {right}. Le propri\xE9taire lui donne un jeton avec plus de droits : Syst\xE8me, Configurer, \xC9crans.
\xE0 jour
position
contredit : {saw}
pas de chaleur
Recherche
r\xE9cent
pas de gaz
pas en charge
son activ\xE9
bureau
tension
pas de vibration
Ce code n'est plus valable : homebot en affiche un autre \xE0 son d\xE9marrage.
texte
fait
porte
supprimer
inclinaison
d\xE9branch\xE9
lampe
enceinte
revient
allumer
refus\xE9
s'ouvre
supprimer # d\xE9finitivement
vert
ouvrir
valeur
vanne
ic\xF4ne
au repos
\xE9teindre
se ferme
refus\xE9 ({policy}) : &
ouvrant
pas de probl\xE8me
D\xE9bits
je l'ai vu
personne
chauffe
temp\xE9rature
pas maintenant
homebot est injoignable
plus fort
lumi\xE8re
pas de pluie
puissance
1 lumi\xE8re
* lumi\xE8res
lave-linge
lampadaire
# d\xE9verrouill\xE9
nom
fermer
arm\xE9, absent
chaud et froid
Cette vue n'existe pas.
arm\xE9, nuit
question
* appareil
d\xE9verrouill\xE9
connect\xE9
quelqu'un est absent
tout allumer
salon
\xE0 regarder seulement
* chiffres
moins fort
mise \xE0 jour disponible
s\xFBr
lecture
code
frais
code pour $
zone
pas de r\xE9ponse en >
effet lumineux
d\xE9sarmer
pas de courant
pas de bruit
annuler
branch\xE9
se d\xE9verrouille
bougie
d\xE9sarm\xE9
pr\xE9sence
consigne de chauffage
d\xE9verrouiller
porte de garage
tond
pi\xE8ces
joignable
< ouvert
maintenant <
remplac\xE9 par une commande plus r\xE9cente
homebot est injoignable depuis > : il red\xE9marre peut-\xEAtre.
interrupteur
tous \xE0 la maison
Accueil
couloir
allumer
chaleur
en charge
\xE0 la maison
* appareils
# est \xE0 la maison
bruit
thermostat
Graphe
injoignable
toilettes
connexion \u2026
effacer
contact
absent
gel
en pause
Plus
Aucun appareil n'a ces mots dans son nom, son type ou sa pi\xE8ce.
arm\xE9 partiel
plus
chambre
p\xE9rim\xE9
d\xE9marrer
\xE9tat
immobile
bandeau
Personne n'en sera plus averti.
se verrouille
droits
nouvelle sc\xE8ne
armement
verrouiller
jour
Pi\xE8ce
pluie
bleu
# ouvert
pi\xE8ce
Configuration
Configurer
dehors
couleur
cam\xE9ra
sir\xE8ne
pile <
au contenu
pas de gel
volet
en mouvement
ex\xE9cuter
arm\xE9, vacances
refroidi \xE0 <
appareil
garage
jardin
enfants
retour \xE0 la base
consigne <
portail
store banne
pile bonne
Il n'y a aucun appareil dans une pi\xE8ce ~.
chaud
refroidissement
consigne de refroidissement
Pi\xE8ces
verrouill\xE9
rideau
caf\xE9
appuyer
chauffage
orange
fen\xEAtre
S\xE9curit\xE9
courant
lampe
moins
neutre
serrure
plus tard
sc\xE8ne
nettoie
Favoris
injoignable
non connect\xE9
\xE0 sa base
supprim\xE9
appui
Climat
d\xE9shumidification
# est absent
frigo
vues
Appuyer encore : $
tout est ferm\xE9
demandes
non approuv\xE9
d\xE9connect\xE9
pas de fum\xE9e
store enrouleur
mesure
s\xE9curit\xE9
luminosit\xE9
\xE9nergie
plafond
salle de bains
dernier \xE9tat connu
avant
annuler #
pile faible
marche/arr\xEAt
Portes, capteurs et autres
aspirateur
mise en tampon
ferm\xE9
Lumi\xE8res
jaune
Routines
d\xE9marrer
fum\xE9e`;export{n as texts};
