var e=`4w2yoNyHmVAl09JSb1NUOOirW8plFHRXtoNfHkuybiocTfoahynbfyP1GPQaNnRXZCvyxccMMyvPypvwg76kJp2QMy4SOPRECIhCpzXzfbx4T80oh8Zuu9YiPab6ybBLWagnQQfpzBOax2M8kz7jw8RDnvVACvROUyfaDvvrm3QJ48RzFkJQnR119wIOs8mtfKz045Jq8LKvOWOIPSPADpsKsnpVxtadOknuuLFl08uANUYifxMX57yxIVrRAgNjakuUPlXUJRz229N4h7YiSrl0ucJNAsLrF72Cy7TQOBodiB6wv9HbtJlBaY8WMk0dRFCV5wgN4LMOviw7mUsPfTjPSAnDM760XnVNoC1pLb2iNuk3JilUxTWUlKxgMtGnQMUwOMF4X4rnqr3K8uAXwt6oMchLyFuQmG2zxWv3TSozKzjfJJ20IkflBhAZAQMEonNJFALraLUVaBRQv7Pm17tJlbfXOgOYKIcca5aoUFqVYPLYzfJ9H7p100c7j5s0F6vSx7pVpsb8tyLBlYVsYZYdefNfeQJ5BDnOrdCuPG9tJAAa2PIky57Bpq6PNgqWfvADAPXkYaSp3VyzgubmDqTrJlSMApfmWMy35Dko0jQDW85dT9beSDrK0BN65ziwEBbuFBiSdpcMIVfHr6HQx8vMAacS0rDCuaL26wCylUAQ2PWpkIJYpBGu7qrDCIITmKuCUxpQVkhGFzHNxugHA8mehzaMmx49gB8hAXyZZyqsepVeDS7c2pPHzrrjQ1Tfnrz8X5lg8plp005MWaYBEoLcU9ezCgQZLI47Q3gKy9Iz7zeWgV97tgFTNtYz1rEaUoKT3JPvocErs8fC0Cpi0FAdXe6Qn4EuNu7fHnzKLioPIRIOQhvGVnAKufCzBt7eh8urvvu9TAhtlVMHTVJFYXrVlfMW9ShxcFmPP4lh8M7JW5K8Cz6IqozuA5ASXGKKJ1bvFTYKEHOYYBwzgCwfwbQb7HLWJNroAqvAttjuu6B3Qg7pHKPF9G37m50QyWmDlhql4zhwWl6NIrjSeE9dV7yTp5PaQSLmaY2iaExHUlJMcm6fMqU3X3xKoKtlbT8T2tnb69haSy8fr9fQTh0FPRxg3EnWIJYjeK3flG4EXUkBt5InRFBykHFGlrT2Wa4oX5v11QgBySOYEefEjmDKVm4ne1UldSlWYyLQ4F4JndG3tq0yHIWDEDTkWNZdqwdOB6NI034RE0eOA825ALtFLdVfuNROVdQKyYhtIGkM7YGrw7UATucq2PfSpUfwx2NLPDlsWbu0oTMLhhw3zqewGbamRhDn44uAxM1vBzE9NnMUuZNMAhb36mpYEumh6lyKXzeqs9fChC2Df0UI7WMkGz476UKewHsGHbrB91oWe6oetmWXtSMG7f4JUJDjQ0M3EDHWnjgDKdnBdMavDxB0RJEgHKOUMkq6mYTAtk37gXpzWZX6LvccJYBW7hxVYC5ZzCm4Wv0PdU2ikP3LuihkUd1Y2Y1rvoXNxxzeIVBVDY3ZFOjovy1eQbJDnildfmZpCOOzSyiqGPAiE6Iv549Uc0zMQn1kdr5E4BtLy0S1wSC1lHnPBOc9tMBTvw2ucf4oRBpIaMtghXUutHTUwYhQkd7ktG2j0qbN8NHnIc7udk3WY9kWWUJ4WTONgrnQ2ZSaHyuGCMWB3WMHk3VjXHf6LVEW8QLGbEweWRkqwMRw91VUByDy3zqCuIby2wKxezVIwZuTlY6KHNpbDQGDUdYTLMQFfAzaEzDmFmTb7xqKIM
Ce que vous changez ici, chaque \xE9cran le montre.
annuler
plus t\xF4t
pas ici
masquer
Masqu\xE9s
se connecter
se d\xE9connecter
Au mur
commence par {view}
au repos
Apr\xE8s cinq minutes, il montre une horloge sombre et ce qui est ouvert. L'adresse de cet \xE9cran :
Sans TLS, un navigateur n'installe pas d'application : tls = true dans [door].
Le certificat auquel vos appareils doivent faire confiance
Langue
Un jeton donne ses droits \xE0 cette page : le v\xF4tre est la ligne dans owner.token, dans le dossier de donn\xE9es de homebot. Pour une tablette, cr\xE9ez-en un avec :
Jeton
le garder dans ce navigateur
continuer sans jeton
r\xE9gler
{least} \xE0 {most}
Nom
\xC9tiquettes
Nom, pi\xE8ce et \xE9tiquettes
une nouvelle pi\xE8ce
la masquer dans la maison
enregistrer
enregistr\xE9
Sans compteur propre
Il n'y a pas (ou plus) d'appareil {name}.
Valeurs
depuis {time}
Commandes
Pourquoi
Son dernier \xE9v\xE9nement, qui n'est pas un \xE9tat :
Il n'a encore signal\xE9 aucun changement.
C'est ainsi depuis que homebot le conna\xEEt.
Un message conserv\xE9 le dit, sans dire depuis quand.
C'\xE9tait ainsi \xE0 son premier signalement.
Il a chang\xE9 \xE0 {time}.
Ce qui est connu, et d'o\xF9
Non compris \xE0 {time} :
vu en dernier
il y a {time}
vous, par {what}
joint par
contradiction
Historique
Rien n'est conserv\xE9 de cette p\xE9riode.
\xC9nergie par jour
{energy} inject\xE9s
\xE9nergie du {day}
Chargement du plan \u2026
Aucune pi\xE8ce n'a encore de forme. Donnez-lui des coins dans la table [places.rooms], ou importez une carte : homebot places import FICHIER.
Rez-de-chauss\xE9e
plan de {count} pi\xE8ce
plan de {count} pi\xE8ces
Un point plein est allum\xE9, ouvert ou occup\xE9.
hors de toutes les pi\xE8ces
inconnu pour l'instant
Chargement des routines \u2026
Il n'y a pas encore de routine.
nouvelle routine
propos\xE9e par {name}
prochaine fois
derni\xE8res fois
lancer maintenant
lui donner le droit
laisser cette routine commander {names}
peut commander
, car la sc\xE8ne {scene} a \xE9t\xE9 appliqu\xE9e
, car la sc\xE8ne {scene} a \xE9t\xE9 annul\xE9e
envoy\xE9 en un seul message au groupe {name}
envoy\xE9 en un seul message \xE0 la sc\xE8ne {name}
Un appareil sans valeur est retir\xE9.
Elle garde les valeurs actuelles de :
Il n'y a rien \xE0 proposer.
Ce qui garde cette sc\xE8ne n'en dit pas les valeurs.
Vos habitudes
accepter
refuser
garder
chaque fois
homebot cherche dans l'historique de quatre semaines ce que vous faites r\xE9guli\xE8rement, et l'observe une semaine avant de le proposer.
observe : {name}
chercher des habitudes
recherche \u2026
supprimer {name}
prendre les valeurs actuelles
vous l'avez fait {time} plus tard
vous l'avez fait {time} avant
vous ne l'avez pas fait
Pendant la semaine d'essai vous l'avez fait {done} fois sur {total} ; une routine aurait raison dans {low} \xE0 {high} % des cas.
when : ce qui la lance, une ligne chacun
if : tout ce qui doit alors \xEAtre vrai
do : ses \xE9tapes, une ligne chacune
si elle d\xE9marre alors qu'elle tourne
le texte
chaque \xE9tape
Aucune des {count} derni\xE8res entr\xE9es n'a ces mots.
Rien ne s'est encore pass\xE9.
les plus r\xE9centes d'abord
le client {name}
un programme inconnu
{issuer} a demand\xE9 {values}
envoy\xE9
renvoy\xE9
le r\xE9seau l'a accept\xE9
a signal\xE9 {values}
pass\xE9 \xE0 {values}
{issuer} a publi\xE9 {text}
{issuer} a \xE9t\xE9 refus\xE9 : {reason}
par {issuer}
, car {device} a signal\xE9 {values}
, \xE0 cause de {what}
, en chemin
, un \xE9cho
, de lui-m\xEAme
, par une personne
, par un autre programme
, par l'appareil ou une personne
permis
passerelle
Interrogation de homebot \u2026
Diagnostic
Tout va bien.
Tout va bien. \xC0 noter :
\u2026 et {count} autres
Apps
Aucune app ne tourne.
Rien n'est encore compt\xE9.
Journal technique
Les lignes apparaissent ici \xE0 mesure.
En attente de votre accord
montrer ce que permet l'accord pour {name}
montrer
L'accord permet ces commandes :
Chang\xE9 depuis le dernier accord :
approuver {name}
Chargement du graphe \u2026
Montrer
Les n\u0153uds \xE0 gauche publient des sujets, ceux \xE0 droite s'y abonnent.
graphe
{nodes} n\u0153uds et {topics} sujets
Les premi\xE8res valeurs arrivent dans deux secondes.
Messages
{what} au fil du temps, {count} points
messages par seconde
Files et pertes
messages en attente ou perdus
en attente
perdus
Boucle d'\xE9v\xE9nements
retard de la boucle d'\xE9v\xE9nements
en retard de
Sujets les plus actifs
Sujet
R\xE9cepteur le plus lent
pi\xE8ce
maintenant
robot
\xE9tiquette
absent
en marche
Couleurs
comme le syst\xE8me
clair
sombre
Cet \xE9cran
Portes et fen\xEAtres
Fum\xE9e, eau, mouvement
favori
Le chauffage marche fen\xEAtre ouverte
R\xE9cemment ici
Autres commandes
Aucun appareil n'indique encore de temp\xE9rature.
Aucun appareil n'indique encore sa puissance ou son \xE9nergie.
Rien de mesur\xE9 ne fonctionne.
Maintenant
Aujourd'hui
Sept jours
Qui la consomme
surtout {name}
{energy} kWh les autres jours semblables
La maison est ouverte
La maison est ferm\xE9e
Il n'y a encore ni serrure, ni contact, ni alarme.
Il n'y a pas d'image.
Cette image n'est plus r\xE9cente.
Valeurs, historique, faits
inconnu : {names}
les derni\xE8res 24 heures
Nom et lieu
Appareils
\xC9crans
\xE9criture \u2026
Ceci est maintenant dans homebot.toml :
annuler
suivant
vers la maison
Fuseau horaire
Latitude
Longitude
Le lieu donne le lever et le coucher du soleil ; il reste ici.
o\xF9 est cet \xE9cran
Un serveur sur cet ordinateur
utiliser {name}
{name} peut commander les appareils
Ajouter
Adresse
Utilisateur
Mot de passe
Les nouvelles passerelles commencent au prochain d\xE9marrage de homebot.
red\xE9marrer homebot
Chaque appareil a une pi\xE8ce.
Aucun appareil pour l'instant.
Chaque \xE9cran a son propre jeton, qui peut lui \xEAtre retir\xE9.
Il peut
regarder
regarder et agir
tout
cr\xE9er un jeton
Ouvrez ceci une fois sur l'\xE9cran ; ce n'est affich\xE9 que maintenant :
Jeton ou code
Le code qu'affiche homebot run laisse entrer un premier \xE9cran.
Cuisine
Salon
Chambre
Salle de bain
Entr\xE9e
Bureau
Jardin
Garage
Cave
Terrasse
Routines toutes pr\xEAtes
routines toutes pr\xEAtes
Aucun appareil de cette maison ne convient : {what}
retour
chauffage
Personnes
Alertes
Sauvegarde
Personne
T\xE9l\xE9phone dans le r\xE9seau
modifier
envoi \u2026
associer
homebot sait qui est \xE0 la maison par les t\xE9l\xE9phones du r\xE9seau et par les traceurs.
Les alertes et les questions vont par ces adresses aux t\xE9l\xE9phones, aux messageries et au courrier.
Le message d'essai est envoy\xE9.
envoyer un message d'essai
Comme ntfy://TOPIC ou mailto://USER:PASSWORD@HOST ; appriseit.com les cite tous.
Elle contient tout ce que homebot garde, sauf les mots de passe.
Dans l\u2019app Maison : +, Ajouter un accessoire, puis scannez ceci ou tapez le code.
Associ\xE9 \xE0 {count} contr\xF4leurs.
les associations avec Apple Home
Code QR
faire une sauvegarde
Elle est en cours \u2026
{name} est t\xE9l\xE9charg\xE9e ({size} ko).
Pour la restaurer :
Omis, car secrets : {files}
Le code sur l'appareil
Appuyez sur le bouton de l'appareil, puis sur \xAB associer \xBB.
encore {count} s
Appuyez sur le bouton : encore {count} s
{name} est associ\xE9.
Trouv\xE9s :
Ses appareils apparaissent ici.
Il faut : {what}
une pression sur son bouton
fum\xE9e ou chaleur
fuite d'eau
sabotage
ouvert depuis longtemps
pile faible
Y a-t-il un feu ? Sortez et appelez les pompiers
Ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
Ni flamme ni interrupteur ; ouvrez les fen\xEAtres, sortez et appelez \xE0 l'aide
coupez l'eau
fermez-le
Son bo\xEEtier est-il ouvert, ou est-il d\xE9croch\xE9 du mur ?
pile, courant, port\xE9e ?
remplacez-la ou chargez-la
homebot show APPAREIL
homebot why APPAREIL montre les signalements
quand
si
faire
ne rien faire
recommencer
ensuite
en m\xEAme temps
droits
demande
toujours demander
approbation
inoffensif
pr\xE9sence
heures calmes
fr\xE9quence
verrouillage
fabricant
mod\xE8le
serrure
store ou volet
climatiseur
vanne d'eau
robot aspirateur
chauffe-eau
humidificateur
tondeuse
centrale d'alarme
capteur d'ouverture
d\xE9tecteur de pr\xE9sence
d\xE9tecteur de fum\xE9e ou de CO
d\xE9tecteur de fuite
capteur de pluie
d\xE9tecteur de gel
capteur de qualit\xE9 de l'air
capteur de sol
capteur de temp\xE9rature
capteur d'humidit\xE9
capteur de luminosit\xE9
capteur de pression
d\xE9bitm\xE8tre
bouton
compteur \xE9lectrique
lecteur vid\xE9o
foyer
traceur
lecteur d'\xE9tiquettes
capteur
d\xE9tecteur
r\xE9glage
mise \xE0 jour
tous \xE0 la maison
d\xE9shumidifie
temp\xE9rature de couleur
vitesse
temp\xE9rature ambiante
mode
action
pr\xE9r\xE9glage
balayage
balayage horizontal
mode du ventilateur
mode
mode
son de la sir\xE8ne
localiser
brut
version
derni\xE8re version
image
fuite d'eau
connexion
pile en charge
pression
d\xE9bit
\xE9nergie inject\xE9e
fr\xE9quence
dioxyde de carbone
monoxyde de carbone
PM10
PM1
compos\xE9s organiques volatils
qualit\xE9 de l'air
humidit\xE9 du sol
force du signal
image de {name}
humide d\xE8s
sonnette
luminosit\xE9
heure du coucher
cong\xE9lateur
limite
apr\xE8s
heure
matin
soir
ouvert depuis
abaiss\xE9
compteur
dur\xE9e
mouvement
sombre sous
commence
finit
plante
autre
dedans
chaud d\xE8s
jours
reste
froid sous
Un ventilateur tourne tant que la salle de bain est humide.
Un bouton commande une lampe.
Un mot aussit\xF4t quand une porte s'ouvre et que personne n'est l\xE0.
Une sonnerie est annonc\xE9e, et \xE9claire l'entr\xE9e dans le noir.
Une lampe est allum\xE9e du cr\xE9puscule au coucher tant que quelqu'un est l\xE0.
Un mot quand un cong\xE9lateur est trop chaud un moment.
Un mot quand le garage reste ouvert, puis encore.
Une pression au lit : tout s'\xE9teint, et un mot si quelque chose est ouvert.
Plus frais quand personne n'est l\xE0, chaud d\xE8s le premier qui rentre.
Plus frais la nuit.
Chaud le matin et le soir.
Un chauffage se repose tant que sa fen\xEAtre est ouverte.
Un mot quand le lave-linge a fini.
Tout s'\xE9teint quand tout le monde est parti.
De la lumi\xE8re tant que quelqu'un bouge et qu'il fait sombre ; une lampe d\xE9j\xE0 allum\xE9e, ou que l'on commande entre-temps, reste comme elle est.
Une lumi\xE8re douce pour le chemin, la nuit.
Un mot quand une plante a soif.
Un mot quand on consomme beaucoup un moment.
Des lampes s'allument et s'\xE9teignent le soir quand personne n'est l\xE0.
Baiss\xE9 aux deux tiers tant qu'il fait chaud.
Baiss\xE9 au cr\xE9puscule, lev\xE9 le matin.
Une prise s'\xE9teint la nuit si son appareil ne fait qu'attendre.
L'aspirateur nettoie une fois par jour quand tout le monde est parti.
Une lampe s'\xE9claircit vingt minutes avant le lever.
De la lumi\xE8re et un mot quand il y a de l'eau o\xF9 il n'en faut pas.
De la lumi\xE8re dans l'entr\xE9e quand la porte s'ouvre dans le noir.
Un mot quand une fen\xEAtre reste ouverte et qu'il fait froid dehors.
configuration erron\xE9e
la corriger, puis : homebot config check
biblioth\xE8que manquante
dossier des donn\xE9es
en devenir propri\xE9taire, ou en nommer un autre dans HOMEBOT_DATA
fichier de donn\xE9es
r\xE9installer le homebot plus r\xE9cent, ou : homebot restore BACKUP
port
si homebot tourne d\xE9j\xE0, demandez-lui : homebot doctor
injoignable
attendre une minute, puis voir le journal de homebot
corriger la cause dans le journal, puis : homebot app reload APP, ou red\xE9marrer homebot
pile, courant, port\xE9e ? S'il est parti pour de bon : homebot forget DEVICE
contest\xE9
homebot show DEVICE montre les deux c\xF4t\xE9s ; homebot forget DEVICE y met fin
le journal a chacune avec sa trace : la signaler ou la corriger
le journal et homebot journal en disent plus
corriger ou retirer l'\xE9metteur
envoie ce que son annonce n'explique pas
corriger l'appareil ou son annonce
secret
plusieurs noms pour un identifiant : peut-\xEAtre plusieurs appareils
donnez \xE0 chaque appareil un identifiant propre dans ses annonces ; d'ici l\xE0, ses parties ont ces noms
sans pi\xE8ce
aspirateurs qui ne sont pas encore des robots
ajouter la table, et red\xE9marrer homebot : docs/robots.md
trouv\xE9s, et pas encore utilis\xE9s
red\xE9marrer homebot apr\xE8s une nouvelle table : docs/protocols.md
re\xE7us
rejet\xE9s
commandes refus\xE9es
commandes \xE9chou\xE9es
annonces
annonces ambigu\xEBs
annonces rejet\xE9es
annonces d\xE9riv\xE9es
annonces diff\xE9r\xE9es
annonces ignor\xE9es
annonces : octets en trop
annonces : octets en m\xE9moire
appareils refus\xE9s
topics refus\xE9s
topics r\xE9serv\xE9s
types refus\xE9s
adresses refus\xE9es
rapports
valeurs refus\xE9es
trop longs
valeurs illisibles
d\xE9faillances
demandes abandonn\xE9es
expirations abandonn\xE9es
quarantaines
fautifs oubli\xE9s
r\xE9ponses
r\xE9ponses tardives
r\xE9ponses inconnues
abandonn\xE9s, trop nombreux
abandonn\xE9s, trop longs
abandonn\xE9s, mal form\xE9s
active
indisponible
\xE9lev\xE9e
faible
normale
signale fum\xE9e ou chaleur
signale du monoxyde de carbone
signale du gaz
est mouill\xE9
est d\xE9clench\xE9e
signale une manipulation
signale un probl\xE8me
est ouvert
a une pile faible
a tourn\xE9
il n'a encore rien signal\xE9 depuis le d\xE9marrage de homebot
il est injoignable
il est silencieux depuis trop longtemps
le propri\xE9taire ne l'a pas approuv\xE9
il a \xE9t\xE9 annonc\xE9 apr\xE8s l'approbation de l'appareil
cela a \xE9t\xE9 annul\xE9
la commande ne tourne pas ; elle red\xE9marre d'elle-m\xEAme, voir Syst\xE8me
la passerelle ne fait qu'observer ; autorisez-la \xE0 commander sous Syst\xE8me, Appareils
homebot tourne \xE0 l'essai et n'envoie rien
arr\xEAt\xE9e
il demande un code
un autre appareil est en cours d'association
le code est faux ; si vous en \xEAtes s\xFBr, r\xE9essayez
il est associ\xE9 ailleurs ; retirez-le l\xE0-bas, ou r\xE9initialisez-le
trop de codes faux ; d\xE9branchez-le un instant
apr\xE8s un code faux, il veut une pause ; r\xE9essayez plus tard
aucun appareil trouv\xE9 avec ce code ; est-il pr\xEAt \xE0 l'association, sur ce r\xE9seau, et pas d\xE9j\xE0 associ\xE9 ?
un code Matter a 11 ou 21 chiffres, ou est un QR code qui commence par MT:
homebot ne peut pas red\xE9marrer seul ici ; relancez-le
il n'y a rien \xE0 annuler, ou le fichier a chang\xE9 depuis
commandes
demandes refus\xE9es
clients coup\xE9s
fragments perdus
retours perdus
messages perdus
connexions refus\xE9es
connexions \xE9chou\xE9es
perdus (QoS 0)
perdus pour des absents
perdus, lecture trop lente
perdus, trop grands
messages refus\xE9s
abonnements refus\xE9s
messages non conserv\xE9s
connexions refus\xE9es au mot de passe
\xE9checs du journal
\xE9checs du fichier des appareils
notifications perdues
notifications \xE9chou\xE9es
identifiants coup\xE9s
\xE9tats perdus
nouvelles manqu\xE9es
annonces refus\xE9es
homebot place APPAREIL PI\xC8CE
titre
artiste
disjoncteur
le broker
aucun programme n'y r\xE9pond : d\xE9marre-le, ou corrige l'adresse
aucune route vers cette machine
pas de r\xE9ponse
le nom de la machine est inconnu : corrige l'adresse
pas encore connect\xE9
non connect\xE9
la connexion a \xE9t\xE9 ferm\xE9e
la connexion a \xE9t\xE9 perdue
le broker ne r\xE9pond plus
l'appareil n'a plus cette partie
c'est contradictoire ; n'en donne qu'un
le code est faux
il n'en a pas
cet appareil n'existe pas
cela rend la maison plus s\xFBre
elle n'a pas de d\xE9tecteur de mouvement
les appareils de la maison ne sont pas encore connus
il n'est pas parmi ce que l'acc\xE8s peut commander
personne n'a \xE9t\xE9 pr\xE9venu ; [notify] et le journal disent pourquoi
il n'y a pas d'adresse : [notify] n'en a aucune
une de ses valeurs est inconnue
rien n'a encore \xE9t\xE9 chang\xE9
c'est dans la configuration ; change [places] l\xE0
HomeKit n'a pas de service pour cela
tout seul
\xE0 la main
par un autre programme
\xE0 la main ou tout seul
la pi\xE8ce de l'appareil est inconnue, il y a donc peut-\xEAtre quelqu'un
il a l'\xE9tiquette always_ask
il d\xE9sarme l'alarme
En vigueur d\xE8s maintenant.
Home Assistant le refuse, ou le code est faux
il a chang\xE9 depuis votre accord
il a chang\xE9 depuis ; regardez-le de nouveau
son mode est inconnu ; r\xE9glez-le d'abord
le thermostat est dans un autre mode ; changez-le d'abord
son autre consigne est inconnue, et les deux vont ensemble
ce mode n'a pas cette consigne
l'appareil ne peut qu'\xEAtre \xE9teint, comme une plaque par s\xE9curit\xE9
ce n'est pas un JPEG, PNG, GIF ou WebP de 2 Mio au plus
le jeton n'est plus valable, ou est celui d'un autre`,n=`gateway {name} is away: {reason}
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
