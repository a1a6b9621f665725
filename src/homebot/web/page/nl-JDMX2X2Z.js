var n=`fbMUyZpzuCwbve3cb9chcon2YzFLpv2nffRtFBS561OQ36t2S9eef2FjmbbriCY2k7luAzl6mtcPDFUOrsk0XIZrZ2tVgyMvTlmZL73zJj0wxAjA9YXIBayWFGJImpY9AcJbuvLqzEJwmBqfgoEjJa7T17MgJbBBuEynOqelVG9VoztuLerutpIyZRKhSstJXbuLjQxDfC8ePvhHwOUAf68yjWpm4uTBR2yzVUm2h2GkSNf94TFOfVHxQnFQVVZX72iy1spbGaq9HJkkFKu0PIQMvz8q8KT6TlNc5B1DDpQYmGgcGcHw4tiWo6koip3tKT9vIUxvhUGRYtZIhMPQ1adUHbftMg0eUxlhoYrktFzXMm9U1HKZuIsVifyXtHaWDSLMOEgXUUl9wYOB1H3emz0jcgcQgADO1s9GfnjEoWvSQZRN2x8jqcAR6Ah954VfgKwHEg9KP7LlnvcrCINZvlrqq857oIO1YkZYsR6eN8bRTPwJfgWCjxHz8BXocF3iiTUxrWC51kXezAvxNOkPI94Hn6gAWrsVaAWlNv8BA1DKhsRWbgMvtEJm8lElWULqmIfATwpU04OREI0F4IoTEfoJVB7EzLawrBEC8do8J4Dv7CB5jI0qfehTwqUzo7mKdB6DSetJjTP8vwZJVQwDzgT7z3tJ4qGQrRdRAyFurHbrFs0KO47nrDyHmZX3TU08aVmilm8tCYRou5GQRyV0wbT1O6B2ENgbhhvbCF6MiAkct8RrPoRzaIpnJXwaXfSDo5xbm9N1JbpKuFeOe4O3kqYx7g3gG7zs0IyEwYqQHiETJsA4AorORcpqStHdtwcjJLfrHeEQKWBA6lFzScU5qpcUVO59CorPpo3BGtzdJDM9Tarftxf3TP8DpVOfdLh9QbeSd984V7323SP746XxMOE4SnIR4RWLsB6wczeFFnNGwgn6BtIZJw7kcqMnGMiOlI4PC9ZFZY9QxkKYLYfVVh3W
pictogram
later
plafond
staande lamp
bureau
strip
lamp
vaatwasser
wasmachine
koelkast
koffie
jaloezie
rolluik
rolgordijn
gordijn
zonnescherm
deur
raam
garagedeur
poort
woonkamer
keuken
gang
kinderen
badkamer
toilet
slaapkamer
kantoor
garage
tuin
kelder
eetkamer
kamer
Plattegrond
Routines
Journaal
Systeem
Graaf
Snelheden
weergaven
{count} apparaat
{count} apparaten
niet aangemeld
verbinden \u2026
homebot is niet bereikbaar
homebot is sinds {time} niet bereikbaar: misschien start het opnieuw.
Die weergave bestaat niet.
niet nu
vraag
ja
nee
minder
meer
meer van {name}
aan
uit
openen
stoppen
sluiten
vergrendelen
ontgrendelen
drukken
ingesteld op {value}
gekoeld tot {value}
Kamer
sc\xE8nes
{name} ongedaan maken
gedaan
ongedaan gemaakt
Apparaten worden geladen \u2026
Er is nog geen apparaat bekend. Ze verschijnen hier zodra ze gevonden zijn.
Zoeken
Geen apparaat heeft deze woorden in naam, soort of kamer.
toon {count} verborgen
Er is geen apparaat in een kamer {room}.
Zonder kamer
laatst bekend
is van eerder: het apparaat heeft zich sinds de start van homebot niet gemeld.
onbereikbaar
stil
niet goedgekeurd
actueel
verouderd
waarde
plattegrond
ik heb het gezien
Niemand krijgt er nog een melding van.
bewerken
verwijderen
{name} definitief verwijderen
nieuwe sc\xE8ne
verwijderd
Toch bedienen?
geweigerd
het was al zo
bevestigd na {time}
tegengesproken: {saw}
het apparaat is verwijderd
geen antwoord binnen {time}
rechten
reservering
apparaat
code
geweigerd ({policy}): {reason}
na {time} teruggesprongen
vervangen door een nieuwere opdracht
alles
naam
onbekend
poort of raam
lamp
thermostaat
ventilator
pomp
camera
sirene
stekker
schakelaar
luidspreker
sc\xE8ne
persoon
batterij
aan
uit
zwenkt niet
zwenkt
geluid aan
gedempt
bereikbaar
onbereikbaar
open
gesloten
gaat open
gaat dicht
gestopt
vrij
bezet
geen rook
rook
geen koolmonoxide
koolmonoxide
geen gas
gas
droog
nat
geen regen
regen
geen vorst
vorst
geen hitte
hitte
geen sabotage
sabotage
geen trilling
trilling
geen geluid
geluid
thuis
iedereen thuis
iemand is weg
stil
in beweging
inactief
geen probleem
probleem
veilig
onveilig
geen licht
licht
geen stroom
stroom
niet aangesloten
aangesloten
niet verbonden
verbonden
vergrendeld
ontgrendeld
vergrendelt
ontgrendelt
geblokkeerd
batterij goed
batterij zwak
laadt niet
laadt op
bijgewerkt
update beschikbaar
vooruit
achteruit
maakt schoon
in het dock
keert terug
gepauzeerd
fout
plek
maait
speelt
buffert
uitgeschakeld
ingeschakeld thuis
ingeschakeld afwezig
ingeschakeld nacht
ingeschakeld vakantie
deels ingeschakeld
wachtend
schakelt in
schakelt uit
geactiveerd
verwarmt
koelt
uit
verwarmen
koelen
automatisch
verwarmen en koelen
drogen
ventileren
thuis
niet thuis
aan/uit
niveau
kleur
effect
beweging
klep
positie
kanteling
slot
richting
stofzuiger
maaier
alarm
afspelen
volume
druk
knop
scan
keuze
getal
tekst
toestand
plaats
contact
aanwezigheid
veiligheid
temperatuur
vochtigheid
lichtsterkte
vermogen
energie
spanning
stroom
fijnstof PM2,5
meting
Thuis
Beveiliging
Klimaat
Energie
Lampen
Meer
1 lamp
{count} lampen
{count} aan
alles uit
alles aan
alles dicht
Deuren, sensoren en andere
Favorieten
Kamers
kamers
overzicht
Vasthouden: {what}
Nog eens drukken: {what}
uitvoeren
uitschakelen
aanzetten
uitzetten
afspelen
pauzeren
starten
starten
pauzeren
terug naar de basis
Laatst
batterij {value}
knoppen, instellingen en updates: {count}
annuleren
wissen
code voor {what}
{count} cijfers
lichteffect
lampen van {room}
luider
zachter
nu {value}
buiten
lamellen
naar de inhoud
wit
kaars
warm
neutraal
daglicht
rood
oranje
geel
groen
blauw
violet
roze
{name} open
{name} van slot
{name} is thuis
{name} is weg
{state} sinds {time}
{value} open
Instellen
Installatie
Er is nog geen apparaat: stel je huis in.
Deze code is niet meer geldig: homebot toont bij de start een nieuwe.
knop
koel
Dit scherm mist het recht {right}. De eigenaar geeft het een token met meer rechten: Systeem, Instellen, Schermen.
alleen kijken
vragen
toevoegen
gewenste temperatuur
koeltemperatuur
gewenste vochtigheid`;export{n as texts};
