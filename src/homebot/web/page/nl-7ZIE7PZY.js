var n=`29 1 fh 1mf 14y 5lx gd 6tu 71n 41y ss 19r acd 8e6 98l 58m g9 84r 2lt afv 6 2el 77 1q2 v8 2ca 4lj 24l fp 1c 4c3 1qf 28f 18a 6e1 2s9 i4b 5vd 6ab 227 2ej 6u f 6yl u6 5 5qc 9d7 48s lil byg 5ek 79r 6sy 8bf 17i 3lh 5t 7zt 28g 5no 7hp f2v 82u 2gg 1tq 2w2 34s 6m6 34n e8m 811 2nm 7wa 148 1js 997 2rl 9iu au1 3am wv 1fl 4xa eb 9cj z63 65z 1cs 406 12g zm 55h 5t 1hq 2n4 4v 4ie 1ft zp 222 2q 7jr ebv z7 cuh 2ku 3at adl 4jh 6uf 2lg 447 2d0 3e4 t4 lr 47l 2ns xm 9b 1 289 z1 222 12u 8zb 4te 9nk a8k i9x 11o acw 52a d87 1 5cy v6 6gs 2p0 th 9l7 75p 44x 8lb k3 144 9r 4w6 7ms 4li d4c 9er 223 542 2cd 34x il 37d 3qn 1pg mg 9c5 9mo 768 uo f3p 8gw 2cf ax anf 1kw i1d 3ku 346 716 47z 1qc 200 8 4nw 4ly 1c5 37q 3yo 4en 1jm 105 ob 1 71 2gp 5v0 1a1 6o3 1wg 1cj i6 5fo 32k 4n5 2zo 2gk eei 763 14y 4o9 zf 2h7 74i 1jw gxh 7la bmd 4xu 4x9 1ec 4r5 3qt 7cp 6in 52y 58p rw 62z 5pq 84k 2yz 3o0 f4p 5 1 6xk 7sv 1g7 640 k 3pw 142 bmc q78 36n 4o5 14z 8v4 251 6mp 43q 212 192 42a 71t 11n 1cv 4dc wf 3xe g4 dvp 7vd 7s7 23f 2lm 2h3 3xl ls 4sv 1ds 64f tk 2u gk8 33r 9gp l8v 25g 5go gjq 3o6 1gi 7pz 3ac 235 2l9 3gz zm 7o7 97j 4nr 2uz enn 18s 20q 7cx 9vq 637 23a 7r5 2xi 8gw 2pp dri j 344 34i j bxh 9c 6z6 1lg aey gsz 3lr da6 2lp 3i 3nv 1c0 mtg it 14c hx 5ic 41x 2iz 245 7ck 90o
nee
aan
ongedaan gemaakt
plaats
overzicht
richting
Er is nog geen apparaat: stel je huis in.
alles uit
speelt
gewenste vochtigheid
fijnstof PM2,5
eetkamer
afspelen
bezet
onbekend
knoppen, instellingen en updates: *
knop
afspelen
probleem
toevoegen
alles
volume
droog
ventilator
gas
schakelt uit
uit
Vasthouden: $
Systeem
rood
nat
ja
gestopt
vochtigheid
pauzeren
stoppen
Plattegrond
vaatwasser
reservering
roze
automatisch
plattegrond
stekker
Laatst
pomp
knop
niveau
sabotage
uit
Toch bedienen?
ventileren
het was al zo
wit
kelder
bewerken
ingeschakeld thuis
geen licht
is van eerder: het apparaat heeft zich sinds de start van homebot niet gemeld.
violet
keuze
gedempt
lamellen
alarm
zwenkt
Energie
geblokkeerd
onveilig
stroom
batterij
koelt
geactiveerd
geen sabotage
Er is nog geen apparaat bekend. Ze verschijnen hier zodra ze gevonden zijn.
Apparaten worden geladen \u2026
wachtend
Zonder kamer
na > teruggesprongen
sc\xE8nes
kantoor
jaloezie
zwenkt niet
stil
uit
achteruit
het apparaat is verwijderd
getal
bevestigd na >
koolmonoxide
{state} sinds >
keuken
toon * verborgen
trilling
beweging
pauzeren
fout
open
Journaal
maaier
lampen van ~
vrij
thuis
geen koolmonoxide
meer van #
effect
* aan
Dit scherm mist het recht {right}. De eigenaar geeft het een token met meer rechten: Systeem, Instellen, Schermen.
bijgewerkt
positie
tegengesproken: {saw}
geen hitte
Zoeken
actueel
geen gas
laadt niet
geluid aan
bureau
spanning
geen trilling
Deze code is niet meer geldig: homebot toont bij de start een nieuwe.
tekst
gedaan
deur
verwijderen
kanteling
niet aangesloten
lamp
luidspreker
keert terug
aanzetten
geweigerd
gaat open
# definitief verwijderen
groen
openen
waarde
klep
pictogram
inactief
uitzetten
gaat dicht
geweigerd ({policy}): &
poort of raam
geen probleem
Snelheden
ik heb het gezien
persoon
verwarmt
temperatuur
niet nu
homebot is niet bereikbaar
luider
licht
geen regen
vermogen
1 lamp
* lampen
wasmachine
staande lamp
# van slot
naam
sluiten
ingeschakeld afwezig
verwarmen en koelen
Die weergave bestaat niet.
ingeschakeld nacht
vraag
* apparaat
ontgrendeld
verbonden
iemand is weg
alles aan
woonkamer
alleen kijken
* cijfers
zachter
update beschikbaar
veilig
scan
code
koel
code voor $
plek
geen antwoord binnen >
lichteffect
uitschakelen
geen stroom
geen geluid
annuleren
aangesloten
ontgrendelt
kaars
uitgeschakeld
aanwezigheid
gewenste temperatuur
ontgrendelen
garagedeur
maait
kamers
bereikbaar
< open
nu <
vervangen door een nieuwere opdracht
homebot is sinds > niet bereikbaar: misschien start het opnieuw.
schakelaar
iedereen thuis
Thuis
gang
aan
hitte
laadt op
thuis
* apparaten
# is thuis
geluid
thermostaat
Graaf
onbereikbaar
toilet
verbinden \u2026
wissen
contact
niet thuis
vorst
gepauzeerd
Meer
Geen apparaat heeft deze woorden in naam, soort of kamer.
deels ingeschakeld
meer
slaapkamer
verouderd
starten
toestand
stil
strip
Niemand krijgt er nog een melding van.
vergrendelt
rechten
nieuwe sc\xE8ne
schakelt in
vergrendelen
daglicht
Kamer
regen
blauw
# open
kamer
Installatie
Instellen
buiten
kleur
camera
sirene
batterij <
naar de inhoud
geen vorst
rolluik
in beweging
uitvoeren
ingeschakeld vakantie
gekoeld tot <
apparaat
garage
tuin
kinderen
terug naar de basis
ingesteld op <
poort
zonnescherm
batterij goed
Er is geen apparaat in een kamer ~.
warm
koelen
koeltemperatuur
Kamers
vergrendeld
gordijn
koffie
drukken
verwarmen
oranje
raam
Beveiliging
stroom
lamp
minder
neutraal
slot
later
sc\xE8ne
maakt schoon
Favorieten
onbereikbaar
niet aangemeld
in het dock
verwijderd
druk
Klimaat
drogen
# is weg
koelkast
weergaven
Nog eens drukken: $
alles dicht
vragen
niet goedgekeurd
niet verbonden
geen rook
rolgordijn
meting
veiligheid
lichtsterkte
energie
plafond
badkamer
laatst bekend
vooruit
# ongedaan maken
batterij zwak
aan/uit
Deuren, sensoren en andere
stofzuiger
buffert
gesloten
Lampen
geel
Routines
starten
rook`;export{n as texts};
