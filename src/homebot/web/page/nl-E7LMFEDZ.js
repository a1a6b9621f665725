var n=`1c 1 aqg 2oh gn9 4 xj m4 7w 3a 2hc xg 1jt mb 6u2 1c7 2dr fsj 1du 3g5 35h 25q 3f8 58 8i6 9hb 12yl 4lo 18i 1q 320 h96 ir 5bl 1a2 1qb 57t 8b 1er d3x i46 bkg tx 8fp 1p5 75 g82 1zw 1i3 1vc a3g dq4 1mj 18i 50n cd 56y e9 3th p0 37a 38 qv dfu 41 8qh k0 1nu 5vw 1x8 41q 300 iiz 4 4z 4e7 3ua 3tz f8 7ep 24m 3ic 4w2 iy 1aw 18g k04 4k7 6m8 b4 3os 142 41v 1k8 lr 1wu az0 dmb yq1 8a7 ft 4mz 3i2 mte wv 1u 6b2 7ju j57 1r8 2cy 21t 8w9 u8 9n6 3h8 5uq 4nf m7 ma 9id 1ml oi 5ph 2bz 1pf 3zx or 33i 1 5vx yv 5e a5i 48v no 4y8 6e8 2y0 xz m2r 15w 9oh 1jt 1j6 77x 119 5w0 qo 2l ad8 1lw 2b3 of 1x5 ev6 2hl 7g9 598 ij es 9 2sc 2 agn 1r6 6t6 e 2pa 51y aux b0y 1v3 2zr 7oc d6 7wx 6i6 4oe fak 2e8 115 4v 3qy 3 1 2h6 1rq 10o ch8 70i 160 2bz 6pq jb 1qy 1fm cdm 1t7 8u9 1f 34e 2b4 j7 s1 2y5 5bj 4jv ob 4b1 5g9 3q9 d61 77y 2qs up7 c i2a 7d4 4sy ftn 5b8 23v 63h 9w3 how 3ot 6e5 962 5cb 5k8 6eu 5fa 3n8 nf0 6t 2tf 3oz l9d 1m3 j9b 6cx ag4 5m9 9n 59j 1wo 18q 33d bhk yx 7sg 8c7 ty 1t 84d h0 5vx 4oy d77 2cm 4ca 2tb ctm 6ar 4wc fk2 8f8 1h0 3t 7ry bn 10j 8aj 7x 6r3 jo7 b9 26m 18g 4l8 4me 8vf 3uy um 3zq 1hw 10c cw el 42f 5fe 1bq 2hr 1br 483 hu jh 2vm 1h7 96w t3 5uz 53l 18 h6 9th aam 22w xg 1yi 1 3hw 7m6 fv 10d po 6i5 ayk h7 6t3 2cp 3xy hu1 dl0 m9 3ml eo
nee
aan
* apparaten
homebot is niet bereikbaar
toevoegen
alles
droog
ventilator
# is weg
gas
uit
rood
nat
ja
gaat dicht
garagedeur
poort of raam
niet verbonden
niet aangesloten
toilet
temperatuur
blauw
Er is nog geen apparaat bekend. Ze verschijnen hier zodra ze gevonden zijn.
niet aangemeld
starten
vrij
gaat open
gang
hitte
openen
thuis
rechten
# is thuis
vaatwasser
schakelt uit
onbereikbaar
deels ingeschakeld
toon * verborgen
kamers
woonkamer
naam
uitvoeren
koeltemperatuur
richting
aanzetten
apparaat
code voor $
lamellen
ontgrendeld
in beweging
bezet
Toch bedienen?
tekst
kanteling
terug naar de basis
koolmonoxide
Deuren, sensoren en andere
sluiten
lampen van ~
lichteffect
afspelen
Graaf
ik heb het gezien
schakelt in
alles dicht
ongedaan gemaakt
verwarmt
ontgrendelt
ontgrendelen
geen hitte
naar de inhoud
zonnescherm
code
koel
drukken
koelen
alleen kijken
stofzuiger
verwarmen en koelen
aan
gordijn
geen vorst
ventileren
geen geluid
vochtigheid
fout
geen sabotage
plafond
pictogram
inactief
vooruit
vergrendeld
geactiveerd
Kamer
later
maaier
raam
buffert
open
gedempt
Laatst
vervangen door een nieuwere opdracht
gesloten
maait
Zonder kamer
rook
geen probleem
weergaven
laatst bekend
* lampen
laadt niet
verwijderd
Beveiliging
verbinden \u2026
Deze code is niet meer geldig: homebot toont bij de start een nieuwe.
geen trilling
speelt
geen antwoord binnen >
groen
afspelen
< open
verwarmen
Die weergave bestaat niet.
trilling
ingeschakeld afwezig
luider
kinderen
bureau
gedaan
deur
batterij zwak
oranje
Meer
wissen
geen stroom
contact
licht
geluid aan
niet goedgekeurd
geweigerd
Zoeken
onbekend
slaapkamer
aan/uit
buiten
zwenkt
kantoor
uit
plaats
niet nu
koffie
gewenste temperatuur
koelkast
uit
rolgordijn
Vasthouden: $
# van slot
keuken
roze
Geen apparaat heeft deze woorden in naam, soort of kamer.
plattegrond
stekker
pomp
knop
gewenste vochtigheid
Snelheden
jaloezie
druk
iedereen thuis
overzicht
meting
batterij
batterij <
lichtsterkte
nu <
aanwezigheid
effect
in het dock
Thuis
Dit scherm mist het recht {right}. De eigenaar geeft het een token met meer rechten: Systeem, Instellen, Schermen.
Journaal
bevestigd na >
pauzeren
verouderd
starten
toestand
stil
knoppen, instellingen en updates: *
strip
persoon
ingesteld op <
stil
keuze
gestopt
bewerken
rolluik
stoppen
niet thuis
verbonden
kleur
batterij goed
1 lamp
laadt op
Er is geen apparaat in een kamer ~.
maakt schoon
koelt
sc\xE8ne
getal
alles aan
wasmachine
Lampen
ingeschakeld thuis
tegengesproken: {saw}
* cijfers
het apparaat is verwijderd
vraag
sirene
# open
spanning
lamp
beweging
uitzetten
iemand is weg
Apparaten worden geladen \u2026
geluid
neutraal
warm
uitgeschakeld
Er is nog geen apparaat: stel je huis in.
bijgewerkt
knop
camera
Instellen
# ongedaan maken
update beschikbaar
achteruit
wit
badkamer
volume
Installatie
vorst
staande lamp
vergrendelt
daglicht
vergrendelen
sabotage
lamp
minder
slot
ingeschakeld nacht
zwenkt niet
zachter
onveilig
gepauzeerd
# definitief verwijderen
actueel
geen gas
geweigerd ({policy}): &
kelder
thermostaat
regen
kamer
meer van #
ingeschakeld vakantie
geel
Niemand krijgt er nog een melding van.
* aan
aangesloten
violet
geblokkeerd
fijnstof PM2,5
{state} sinds >
alles uit
gekoeld tot <
verwijderen
vragen
annuleren
kaars
stroom
probleem
geen rook
uitschakelen
energie
Routines
nieuwe sc\xE8ne
geen licht
luidspreker
thuis
homebot is sinds > niet bereikbaar: misschien start het opnieuw.
Nog eens drukken: $
drogen
poort
stroom
is van eerder: het apparaat heeft zich sinds de start van homebot niet gemeld.
na > teruggesprongen
geen koolmonoxide
Kamers
Plattegrond
pauzeren
alarm
Systeem
eetkamer
Klimaat
Favorieten
sc\xE8nes
positie
geen regen
* apparaat
garage
tuin
waarde
klep
Energie
onbereikbaar
meer
keert terug
reservering
niveau
wachtend
veiligheid
vermogen
bereikbaar
het was al zo
automatisch
veilig
scan
schakelaar
plek`;export{n as texts};
