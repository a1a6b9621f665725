var n=`fbMUyZpzuCwbve3cb9chcon2YzFLpv2nffRtFBS561OQ36t2S9eef2FjmbbriCY2k7luAzl6mtcPDFUOrsk0XIZrZ2tVgyMvTlmZL73zJj0wxAjA9YXIBayWFGJImpY9AcJbuvLqzEJwmBqfgoEjJa7T17MgJbBBuEynOqelVG9VoztuLerutpIyZRKhSstJXbuLjQxDfC8ePvhHwOUAf68yjWpm4uTBR2yzVUm2h2GkSNf94TFOfVHxQnFQVVZX72iy1spbGaq9HJkkFKu0PIQMvz8q8KT6TlNc5B1DDpQYmGgcGcHw4tiWo6koip3tKT9vIUxvhUGRYtZIhMPQ1adUHbftMg0eUxlhoYrktFzXMm9U1HKZuIsVifyXtHaWDSLMOEgXUUl9wYOB1H3emz0jcgcQgADO1s9GfnjEoWvSQZRN2x8jqcAR6Ah954VfgKwHEg9KP7LlnvcrCINZvlrqq857oIO1YkZYsR6eN8bRTPwJfgWCjxHz8BXocF3iiTUxrWC51kXezAvxNOkPI94Hn6gAWrsVaAWlNv8BA1DKhsRWbgMvtEJm8lElWULqmIfATwpU04OREI0F4IoTEfoJVB7EzLawrBEC8do8J4Dv7CB5jI0qfehTwqUzo7mKdB6DSetJjTP8vwZJVQwDzgT7z3tJ4qGQrRdRAyFurHbrFs0KO47nrDyHmZX3TU08aVmilm8tCYRou5GQRyV0wbT1O6B2ENgbhhvbCF6MiAkct8RrPoRzaIpnJXwaXfSDo5xbm9N1JbpKuFeOe4O3kqYx7g3gG7zs0IyEwYqQHiETJsA4AorORcpqStHdtwcjJLfrHeEQKWBA6lFzScU5qpcUVO59CorPpo3BGtzdJDM9Tarftxf3TP8DpVOfdLh9QbeSd984V7323SP746XxMOE4SnIR4RWLsB6wczeFFnNGwgn6BtIZJw7kcqMnGMiOlI4PC9ZFZY9QxkKYLYfVVh3W
ic\xF4ne
plus tard
plafond
lampadaire
bureau
bandeau
lampe
lave-vaisselle
lave-linge
frigo
caf\xE9
store
volet
store enrouleur
rideau
store banne
porte
fen\xEAtre
porte de garage
portail
salon
cuisine
couloir
enfants
salle de bains
toilettes
chambre
bureau
garage
jardin
cave
salle \xE0 manger
pi\xE8ce
Plan
Routines
Journal
Syst\xE8me
Graphe
D\xE9bits
vues
{count} appareil
{count} appareils
non connect\xE9
connexion \u2026
homebot est injoignable
homebot est injoignable depuis {time} : il red\xE9marre peut-\xEAtre.
Cette vue n'existe pas.
pas maintenant
question
oui
non
moins
plus
plus de {name}
allumer
\xE9teindre
ouvrir
arr\xEAter
fermer
verrouiller
d\xE9verrouiller
appuyer
consigne {value}
refroidi \xE0 {value}
Pi\xE8ce
sc\xE8nes
annuler {name}
fait
annul\xE9
Chargement des appareils \u2026
Aucun appareil n'est encore connu. Ils apparaissent ici d\xE8s qu'ils sont trouv\xE9s.
Recherche
Aucun appareil n'a ces mots dans son nom, son type ou sa pi\xE8ce.
afficher {count} masqu\xE9s
Il n'y a aucun appareil dans une pi\xE8ce {room}.
Sans pi\xE8ce
dernier \xE9tat connu
date d'avant : l'appareil n'a rien signal\xE9 depuis le d\xE9marrage de homebot.
injoignable
silencieux
non approuv\xE9
r\xE9cent
p\xE9rim\xE9
valeur
plan
je l'ai vu
Personne n'en sera plus averti.
modifier
supprimer
supprimer {name} d\xE9finitivement
nouvelle sc\xE8ne
supprim\xE9
Commander quand m\xEAme ?
refus\xE9
c'\xE9tait d\xE9j\xE0 ainsi
confirm\xE9 apr\xE8s {time}
contredit : {saw}
l'appareil a \xE9t\xE9 retir\xE9
pas de r\xE9ponse en {time}
droits
r\xE9servation
appareil
code
refus\xE9 ({policy}) : {reason}
revenu apr\xE8s {time}
remplac\xE9 par une commande plus r\xE9cente
tout
nom
inconnu
ouvrant
lampe
thermostat
ventilateur
pompe
cam\xE9ra
sir\xE8ne
prise
interrupteur
enceinte
sc\xE8ne
personne
pile
allum\xE9
\xE9teint
n'oscille pas
oscillation
son activ\xE9
son coup\xE9
joignable
injoignable
ouvert
ferm\xE9
s'ouvre
se ferme
arr\xEAt\xE9
libre
occup\xE9
pas de fum\xE9e
fum\xE9e
pas de monoxyde de carbone
monoxyde de carbone
pas de gaz
gaz
sec
mouill\xE9
pas de pluie
pluie
pas de gel
gel
pas de chaleur
chaleur
pas de sabotage
sabotage
pas de vibration
vibration
pas de bruit
bruit
\xE0 la maison
tous \xE0 la maison
quelqu'un est absent
immobile
en mouvement
au repos
pas de probl\xE8me
probl\xE8me
s\xFBr
dangereux
pas de lumi\xE8re
lumi\xE8re
pas de courant
courant
d\xE9branch\xE9
branch\xE9
d\xE9connect\xE9
connect\xE9
verrouill\xE9
d\xE9verrouill\xE9
se verrouille
se d\xE9verrouille
bloqu\xE9
pile bonne
pile faible
pas en charge
en charge
\xE0 jour
mise \xE0 jour disponible
avant
arri\xE8re
nettoie
\xE0 sa base
revient
en pause
erreur
zone
tond
lecture
mise en tampon
d\xE9sarm\xE9
arm\xE9, pr\xE9sent
arm\xE9, absent
arm\xE9, nuit
arm\xE9, vacances
arm\xE9 partiel
en attente
armement
d\xE9sarmement
d\xE9clench\xE9
chauffe
refroidit
arr\xEAt
chauffage
refroidissement
automatique
chaud et froid
d\xE9shumidification
ventilation
\xE0 la maison
absent
marche/arr\xEAt
intensit\xE9
couleur
effet
mouvement
vanne
position
inclinaison
serrure
sens
aspirateur
tondeuse
alarme
lecture
volume
appui
bouton
lecture
choix
nombre
texte
\xE9tat
lieu
contact
pr\xE9sence
s\xE9curit\xE9
temp\xE9rature
humidit\xE9
luminosit\xE9
puissance
\xE9nergie
tension
courant
PM2,5
mesure
Accueil
S\xE9curit\xE9
Climat
\xC9nergie
Lumi\xE8res
Plus
1 lumi\xE8re
{count} lumi\xE8res
{count} allum\xE9es
tout \xE9teindre
tout allumer
tout est ferm\xE9
Portes, capteurs et autres
Favoris
Pi\xE8ces
pi\xE8ces
r\xE9sum\xE9
Maintenir : {what}
Appuyer encore : {what}
ex\xE9cuter
d\xE9sarmer
allumer
\xE9teindre
lire
mettre en pause
d\xE9marrer
d\xE9marrer
mettre en pause
retour \xE0 la base
R\xE9cemment
pile {value}
boutons, r\xE9glages et mises \xE0 jour : {count}
annuler
effacer
code pour {what}
{count} chiffres
effet lumineux
lumi\xE8res de {room}
plus fort
moins fort
maintenant {value}
dehors
lames
au contenu
blanc
bougie
chaud
neutre
jour
rouge
orange
jaune
vert
bleu
violet
rose
{name} ouvert
{name} d\xE9verrouill\xE9
{name} est \xE0 la maison
{name} est absent
{state} depuis {time}
{value} ouvert
Configurer
Configuration
Aucun appareil pour l'instant : configurez votre maison.
Ce code n'est plus valable : homebot en affiche un autre \xE0 son d\xE9marrage.
bouton
frais
Il manque \xE0 cet \xE9cran le droit {right}. Le propri\xE9taire lui donne un jeton avec plus de droits : Syst\xE8me, Configurer, \xC9crans.
\xE0 regarder seulement
demandes
ajouter
consigne de chauffage
consigne de refroidissement
consigne d'humidit\xE9`;export{n as texts};
