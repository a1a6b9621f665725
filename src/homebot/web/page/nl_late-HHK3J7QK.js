var e=`4w2yoNyHmVAl09JSb1NUOOirW8plFHRXtoNfHkuybiocTfoahynbfyP1GPQaNnRXZCvyxccMMyvPypvwg76kJp2QMy4SOPRECIhCpzXzfbx4T80oh8Zuu9YiPab6ybBLWagnQQfpzBOax2M8kz7jw8RDnvVACvROUyfaDvvrm3QJ48RzFkJQnR119wIOs8mtfKz045Jq8LKvOWOIPSPADpsKsnpVxtadOknuuLFl08uANUYifxMX57yxIVrRAgNjakuUPlXUJRz229N4h7YiSrl0ucJNAsLrF72Cy7TQOBodiB6wv9HbtJlBaY8WMk0dRFCV5wgN4LMOviw7mUsPfTjPSAnDM760XnVNoC1pLb2iNuk3JilUxTWUlKxgMtGnQMUwOMF4X4rnqr3K8uAXwt6oMchLyFuQmG2zxWv3TSozKzjfJJ20IkflBhAZAQMEonNJFALraLUVaBRQv7Pm17tJlbfXOgOYKIcca5aoUFqVYPLYzfJ9H7p100c7j5s0F6vSx7pVpsb8tyLBlYVsYZYdefNfeQJ5BDnOrdCuPG9tJAAa2PIky57Bpq6PNgqWfvADAPXkYaSp3VyzgubmDqTrJlSMApfmWMy35Dko0jQDW85dT9beSDrK0BN65ziwEBbuFBiSdpcMIVfHr6HQx8vMAacS0rDCuaL26wCylUAQ2PWpkIJYpBGu7qrDCIITmKuCUxpQVkhGFzHNxugHA8mehzaMmx49gB8hAXyZZyqsepVeDS7c2pPHzrrjQ1Tfnrz8X5lg8plp005MWaYBEoLcU9ezCgQZLI47Q3gKy9Iz7zeWgV97tgFTNtYz1rEaUoKT3JPvocErs8fC0Cpi0FAdXe6Qn4EuNu7fHnzKLioPIRIOQhvGVnAKufCzBt7eh8urvvu9TAhtlVMHTVJFYXrVlfMW9ShxcFmPP4lh8M7JW5K8Cz6IqozuA5ASXGKKJ1bvFTYKEHOYYBwzgCwfwbQb7HLWJNroAqvAttjuu6B3Qg7pHKPF9G37m50QyWmDlhql4zhwWl6NIrjSeE9dV7yTp5PaQSLmaY2iaExHUlJMcm6fMqU3X3xKoKtlbT8T2tnb69haSy8fr9fQTh0FPRxg3EnWIJYjeK3flG4EXUkBt5InRFBykHFGlrT2Wa4oX5v11QgBySOYEefEjmDKVm4ne1UldSlWYyLQ4F4JndG3tq0yHIWDEDTkWNZdqwdOB6NI034RE0eOA825ALtFLdVfuNROVdQKyYhtIGkM7YGrw7UATucq2PfSpUfwx2NLPDlsWbu0oTMLhhw3zqewGbamRhDn44uAxM1vBzE9NnMUuZNMAhb36mpYEumh6lyKXzeqs9fChC2Df0UI7WMkGz476UKewHsGHbrB91oWe6oetmWXtSMG7f4JUJDjQ0M3EDHWnjgDKdnBdMavDxB0RJEgHKOUMkq6mYTAtk37gXpzWZX6LvccJYBW7hxVYC5ZzCm4Wv0PdU2ikP3LuihkUd1Y2Y1rvoXNxxzeIVBVDY3ZFOjovy1eQbJDnildfmZpCOOzSyiqGPAiE6Iv549Uc0zMQn1kdr5E4BtLy0S1wSC1lHnPBOc9tMBTvw2ucf4oRBpIaMtghXUutHTUwYhQkd7ktG2j0qbN8NHnIc7udk3WY9kWWUJ4WTONgrnQ2ZSaHyuGCMWB3WMHk3VjXHf6LVEW8QLGbEweWRkqwMRw91VUByDy3zqCuIby2wKxezVIwZuTlY6KHNpbDQGDUdYTLMQFfAzaEzDmFmTb7xqKIM
Wat je hier verandert, toont elk scherm.
ongedaan maken
eerder
niet hier
verbergen
Verborgen
aanmelden
afmelden
Aan een muur
begint met {view}
in rust
Na vijf minuten toont het een gedimde klok en wat open is. Het adres van dit scherm:
Zonder TLS installeert een browser geen app: tls = true in [door].
Het certificaat dat je apparaten moeten vertrouwen
Taal
Een token geeft deze pagina haar rechten: het jouwe is de regel in owner.token, in de gegevensmap van homebot. Voor een tablet maak je er een met:
Token
in deze browser bewaren
doorgaan zonder token
instellen
{least} tot {most}
Naam
Labels
Naam, kamer en labels
een nieuwe kamer
verbergen in het huis
opslaan
opgeslagen
Zonder eigen meter
Er is geen apparaat {name} (meer).
Waarden
sinds {time}
Opdrachten
Waarom
Zijn laatste gebeurtenis, die geen toestand is:
Het heeft nog geen verandering gemeld.
Het is zo sinds homebot het kent.
Een bewaard bericht zegt het, maar niet sinds wanneer.
Het was zo bij de eerste melding.
Het veranderde om {time}.
Wat bekend is, en waarvan
Niet begrepen om {time}:
laatst gezien
{time} geleden
jij, door {what}
bereikt via
tegenstrijdig
Geschiedenis
Van die tijd is niets bewaard.
Energie per dag
{energy} teruggeleverd
energie van {day}
Plattegrond wordt geladen \u2026
Nog geen kamer heeft een vorm. Geef haar hoeken in de tabel [places.rooms], of lees een kaart in: homebot places import BESTAND.
Begane grond
plattegrond met {count} kamer
plattegrond met {count} kamers
Een volle stip is aan, open of bezet.
buiten alle kamers
nu niet bekend
Routines worden geladen \u2026
Er is nog geen routine.
nieuwe routine
voorgesteld door {name}
volgende keer
laatste keren
nu uitvoeren
geef het recht
deze routine {names} laten bedienen
mag bedienen
, omdat de sc\xE8ne {scene} is toegepast
, omdat de sc\xE8ne {scene} ongedaan is gemaakt
verzonden in \xE9\xE9n bericht aan de groep {name}
verzonden in \xE9\xE9n bericht aan de sc\xE8ne {name}
Een apparaat zonder waarde valt weg.
Ze bewaart de huidige waarden van:
Er is niets voor te stellen.
Wat deze sc\xE8ne bewaart, zegt de waarden niet.
Je gewoonten
aannemen
afwijzen
behouden
elke keer
homebot zoekt in de geschiedenis van vier weken wat je steeds weer doet, en kijkt een week toe voordat het dat voorstelt.
kijkt naar: {name}
gewoonten zoeken
zoeken \u2026
{name} verwijderen
de huidige waarden nemen
je deed het {time} later
je deed het {time} eerder
je deed het niet
In de proefweek deed je dit {done} van de {total} keer; een routine zou het in {low} tot {high} % van de gevallen goed doen.
when: wat haar start, elk een regel
if: wat dan allemaal moet gelden
do: haar stappen, elk een regel
als ze start terwijl ze loopt
de tekst
elke stap
Geen van de nieuwste {count} regels heeft deze woorden.
Er is nog niets gebeurd.
nieuwste eerst
de client {name}
een onbekend programma
{issuer} vroeg om {values}
verzonden
opnieuw verzonden
het netwerk nam het aan
meldde {values}
veranderd naar {values}
{issuer} publiceerde {text}
{issuer} werd geweigerd: {reason}
door {issuer}
, omdat {device} {values} meldde
, wegens {what}
, onderweg
, een echo
, vanzelf
, door een mens
, door een ander programma
, door het apparaat of een mens
toegestaan
gateway
homebot wordt bevraagd \u2026
Diagnose
Alles is in orde.
Alles is in orde. Let op:
\u2026 en nog {count}
Apps
Er draait geen app.
Er is nog niets geteld.
Logboek
Regels verschijnen hier zodra ze komen.
Wacht op je goedkeuring
toon wat goedkeuring van {name} toestaat
tonen
Goedkeuring staat deze opdrachten toe:
Veranderd sinds de vorige goedkeuring:
{name} goedkeuren
Graaf wordt geladen \u2026
Toon
Knopen links publiceren onderwerpen, knopen rechts abonneren zich erop.
graaf
{nodes} knopen en {topics} onderwerpen
De eerste waarden komen over twee seconden.
Berichten
{what} in de tijd, {count} punten
berichten per seconde
Wachtrijen en verliezen
wachtende en verloren berichten
wachtend
verloren
Event-loop
vertraging van de event-loop
te laat met
Drukste onderwerpen
Onderwerp
Traagste ontvanger
kamer
nu
robot
tag
afwezig
bezig
Kleuren
zoals het systeem
licht
donker
Dit scherm
Deuren en ramen
Rook, water, beweging
favoriet
Er wordt gestookt met een raam open
Laatst hier
Meer bediening
Nog geen apparaat meldt een temperatuur.
Nog geen apparaat meldt vermogen of energie.
Niets dat gemeten wordt staat aan.
Nu
Vandaag
Zeven dagen
Wie het nu gebruikt
meest door {name}
{energy} kWh op andere zulke dagen
Het huis is open
Het huis is dicht
Er is nog geen slot, contact of alarm.
Er is geen beeld.
Dit beeld is niet meer nieuw.
Waarden, verloop, feiten
niet bekend: {names}
de laatste 24 uur
Naam en plaats
Apparaten
Schermen
schrijven \u2026
Dit staat nu in homebot.toml:
ongedaan maken
verder
naar het huis
Tijdzone
Breedtegraad
Lengtegraad
De plaats geeft zonsopgang en zonsondergang; die blijft hier.
waar dit scherm is
Een server op deze computer
{name} gebruiken
{name} mag apparaten bedienen
Toevoegen
Adres
Gebruiker
Wachtwoord
Nieuwe gateways beginnen bij de volgende start van homebot.
homebot opnieuw starten
Elk apparaat heeft een kamer.
Er is nog geen apparaat.
Elk scherm heeft een eigen token, dat kan worden ingetrokken.
Het mag
kijken
kijken en bedienen
alles
token maken
Open dit \xE9\xE9n keer op het scherm; het wordt alleen nu getoond:
Token of code
De code die homebot run toont, laat het eerste scherm binnen.
Keuken
Woonkamer
Slaapkamer
Badkamer
Hal
Werkkamer
Tuin
Garage
Kelder
Terras
Kant-en-klare routines
kant-en-klare routines
Geen apparaat van dit huis past: {what}
terug
verwarming
Personen
Alarmen
Back-up
Persoon
Telefoon in het netwerk
wijzigen
wordt verzonden \u2026
koppelen
homebot weet wie er thuis is door telefoons in het netwerk en door trackers.
Alarmen en vragen gaan via deze adressen naar telefoons, chats en e-mail.
Het testbericht is verzonden.
testbericht sturen
Zoals ntfy://TOPIC of mailto://USER:PASSWORD@HOST; appriseit.com noemt ze alle.
Hij bevat alles wat homebot bewaart, maar geen wachtwoorden.
In de app Woning: +, Voeg accessoire toe, en scan dit of typ de code.
Gekoppeld met {count} bedieningen.
de koppelingen met Apple Home
QR-code
back-up maken
Hij wordt gemaakt \u2026
{name} is gedownload ({size} kB).
Om hem terug te zetten:
Weggelaten, want geheim: {files}
De code op het apparaat
Druk op de knop van het apparaat en dan op \u2018koppelen\u2019.
nog {count} s
Druk nu op de knop: nog {count} s
{name} is gekoppeld.
Gevonden:
De apparaten ervan verschijnen hier.
Nodig is: {what}
een druk op zijn knop
rook of hitte
lekkage
sabotage
lang open
zwakke batterij
Is er brand? Ga naar buiten en bel de brandweer
Open de ramen, ga naar buiten en roep hulp
Geen vlam en geen schakelaar; open de ramen, ga naar buiten en roep hulp
sluit het water af
sluit het
Is de behuizing open, of is het van de muur?
batterij, stroom, bereik?
vervang of laad hem op
homebot show APPARAAT
homebot why APPARAAT toont de meldingen
wanneer
als
doe
niets doen
opnieuw beginnen
daarna
tegelijk
rechten
navraag
altijd vragen
goedkeuring
ongevaarlijk
aanwezigheid
stille uren
frequentie
vergrendeling
fabrikant
model
deurslot
rolluik of gordijn
airconditioner
waterklep
robotstofzuiger
boiler
luchtbevochtiger
grasmaaier
alarmcentrale
contactsensor
bewegingsmelder
rook- of CO-melder
watermelder
regensensor
vorstmelder
luchtkwaliteitssensor
bodemsensor
temperatuursensor
vochtsensor
lichtsensor
druksensor
debietsensor
drukknop
elektriciteitsmeter
videospeler
huishouden
tracker
taglezer
sensor
melder
instelling
update
allen thuis
droogt
kleurtemperatuur
snelheid
kamertemperatuur
stand
activiteit
voorinstelling
zwenken
horizontaal zwenken
ventilatorstand
stand
stand
sirenetoon
zoeken
ruw
versie
nieuwste versie
beeld
lekkage
verbinding
batterij laadt
druk
debiet
teruggeleverde energie
frequentie
koolstofdioxide
koolmonoxide
fijnstof PM10
fijnstof PM1
vluchtige stoffen
luchtkwaliteit
bodemvocht
signaalsterkte
beeld van {name}
vochtig vanaf
bel
helderheid
bedtijd
vriezer
grens
na
tijd
ochtend
avond
open sinds
verlaagd
meter
lang
beweging
donker onder
begint
eindigt
plant
andere
binnen
heet vanaf
dagen
blijft
koud onder
Een ventilator draait zolang de badkamer vochtig is.
Een knop schakelt een lamp.
Meteen een bericht als een deur opengaat en niemand thuis is.
Aanbellen wordt gemeld, en verlicht in het donker de ingang.
Een lamp brandt van schemering tot bedtijd als er iemand thuis is.
Een bericht als een vriezer een tijd te warm is.
Een bericht als de garage open blijft, en telkens weer.
E\xE9n druk bij het bed: alle lichten uit, en een bericht als iets open is.
Koeler als niemand thuis is, weer warm met de eerste die komt.
's Nachts koeler.
's Ochtends en 's avonds warm.
Een verwarming rust zolang haar raam open is.
Een bericht als de wasmachine klaar is.
Alle lichten gaan uit als iedereen weg is.
Licht zolang iemand beweegt en het donker is; een lamp die al brandt of die iemand intussen schakelt, blijft zoals ze is.
Een zacht licht voor de weg 's nachts.
Een bericht als een plant water nodig heeft.
Een bericht als een tijd veel stroom wordt gebruikt.
Lampen gaan 's avonds aan en uit als niemand thuis is.
Voor twee derde omlaag zolang het heet is.
Omlaag bij schemering, omhoog in de ochtend.
Een stekker gaat 's nachts uit als zijn apparaat alleen wacht.
De stofzuiger maakt eens per dag schoon als iedereen weg is.
Een lamp wordt twintig minuten lang lichter voor je opstaat.
Licht en een bericht als er water is waar het niet hoort.
Licht in de gang als de voordeur in het donker opengaat.
Een bericht als een raam open blijft terwijl het buiten koud is.
foute configuratie
verbeteren, dan: homebot config check
ontbrekende bibliotheek
map voor gegevens
maak hem van jou, of noem een andere in HOMEBOT_DATA
gegevensbestand
installeer de nieuwere homebot weer, of: homebot restore BACKUP
poort
draait homebot al, vraag het: homebot doctor
niet bereikbaar
wacht een minuut, kijk dan in het logboek
verhelp de oorzaak in het logboek, dan: homebot app reload APP, of start homebot opnieuw
batterij, stroom, bereik? Is het voorgoed weg: homebot forget DEVICE
betwist
homebot show DEVICE toont beide kanten; homebot forget DEVICE be\xEBindigt het
het logboek heeft elk met zijn spoor: meld of verhelp het
het logboek en homebot journal zeggen meer
herstel of verwijder de afzender
zendt wat zijn aankondiging niet verklaart
verbeter het apparaat of zijn aankondiging
geheim
meerdere namen voor \xE9\xE9n kenmerk: misschien meerdere apparaten
geef elk apparaat een eigen kenmerk in zijn aankondigingen; tot dan hebben zijn delen deze namen
zonder kamer
stofzuigers die nog geen robots zijn
voeg de tabel toe en start homebot opnieuw: docs/robots.md
gevonden en nog niet gebruikt
start homebot opnieuw na een nieuwe tabel: docs/protocols.md
ontvangen
afgewezen
geweigerde opdrachten
mislukte opdrachten
aankondigingen
dubbelzinnige aankondigingen
afgewezen aankondigingen
afgeleide aankondigingen
uitgestelde aankondigingen
genegeerde aankondigingen
aankondigingen: bytes te veel
aankondigingen: bytes geheugen
geweigerde apparaten
geweigerde topics
gereserveerde topics
geweigerde typen
geweigerde adressen
meldingen
geweigerde waarden
te lang
onleesbare waarden
fouten
vervallen vragen
vervallen termijnen
quarantaines
vergeten stoorders
antwoorden
late antwoorden
onbekende antwoorden
vervallen, te veel
vervallen, te lang
vervallen, misvormd
actief
niet beschikbaar
hoog
laag
normaal
meldt rook of hitte
meldt koolmonoxide
meldt gas
is nat
is afgegaan
meldt sabotage
meldt een probleem
staat open
heeft een zwakke batterij
liep
het heeft sinds de start van homebot nog niets gemeld
het is onbereikbaar
het is te lang stil
de eigenaar heeft het niet goedgekeurd
het werd aangekondigd nadat het apparaat was goedgekeurd
het is afgebroken
de besturing draait niet; ze start vanzelf opnieuw, zie Systeem
de gateway kijkt alleen; sta opdrachten toe onder Systeem, Apparaten
homebot draait op proef en verstuurt niets
gestopt
het heeft een code nodig
er wordt al een ander apparaat gekoppeld
de code is fout; weet je het zeker, probeer het dan nog eens
het is al elders gekoppeld; verwijder het daar of herstel het
te veel foute codes; haal het even van de stroom
na een foute code wil het een pauze; probeer het later
met deze code is geen apparaat gevonden; is het klaar om te koppelen, in dit netwerk en nog nergens gekoppeld?
een Matter-code heeft 11 of 21 cijfers, of is een QR-code die met MT: begint
homebot kan hier niet zelf herstarten; start het opnieuw
er is niets terug te nemen, of het bestand is sindsdien veranderd
opdrachten
geweigerde verzoeken
verbroken clients
weggegooide delen
verloren terugmeldingen
verloren berichten
geweigerde verbindingen
mislukte verbindingen
weggegooid (QoS 0)
weggegooid voor afwezigen
weggegooid, te langzaam gelezen
weggegooid, te groot
geweigerde berichten
geweigerde abonnementen
niet bewaarde berichten
mislukte aanmeldingen
fouten van het journaal
fouten van het apparatenbestand
weggegooide meldingen
mislukte meldingen
ingekorte kenmerken
verloren toestanden
gemiste berichten
geweigerde aankondigingen
homebot place APPARAAT KAMER
titel
artiest
stroomonderbreker
de broker
daar antwoordt geen programma: start het, of verbeter het adres
geen route naar die computer
geen antwoord
de naam van de computer is onbekend: verbeter het adres
nog niet verbonden
niet verbonden
de verbinding is gesloten
de verbinding is verbroken
de broker antwoordt niet meer
het apparaat heeft dat deel niet meer
dat spreekt elkaar tegen; geef er \xE9\xE9n
de code is fout
het heeft er geen
dat apparaat is er niet
het maakt het huis veiliger
die heeft geen bewegingsmelder
de apparaten van het huis zijn nog niet bekend
het hoort niet bij wat de toegang mag bedienen
niemand is ingelicht; [notify] en het log zeggen waarom
er is geen adres: in [notify] staat er geen
een van zijn waarden is onbekend
er is nog niets gewijzigd
het staat in de configuratie; wijzig daar [places]
HomeKit heeft er geen dienst voor
vanzelf
met de hand
door een ander programma
met de hand of vanzelf
de kamer van het apparaat is onbekend, dus er is misschien iemand
het heeft het label always_ask
het schakelt het alarm uit
Geldt vanaf nu.
Home Assistant weigert het, of de code is fout
het is veranderd sinds je akkoord
het is sindsdien veranderd; bekijk het opnieuw
zijn stand is onbekend; stel die eerst in
de thermostaat staat in een andere stand; wijzig die eerst
zijn andere doelwaarde is onbekend, en beide horen samen
die stand heeft deze doelwaarde niet
het apparaat kan alleen uit, zoals een kookplaat voor de veiligheid
het is geen JPEG, PNG, GIF of WebP tot 2 MiB
het token geldt niet meer, of hoort bij iets anders`,n=`gateway {name} is away: {reason}
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
gateway {name} is weg: {reason}
{name} antwoordde niet binnen {count} s; onbekend of het gebeurde
geweigerd ({value}): {reason}
ging na {count} s terug, {value}
niet verzonden: {reason}
tegengesproken: {reason}
de naam van de computer is nu niet op te zoeken ({what})
{value} sloot de verbinding
{name} is niet verbonden: {reason}
{name} is niet verbonden
{name} antwoordde niet binnen {count} s
{name} slaapt; probeer het als het wakker is
{name} is niet beschikbaar in Home Assistant
Home Assistant heeft geen entiteit meer voor {name}
{name} heeft geen driver; \`homebot doctor\` noemt wat niet bruikbaar is
het certificaat van {name} wordt niet vertrouwd
{what}: de server antwoordt {count}, later lukt het misschien
de server antwoordt {count}
het vraagt een wachtwoord (status {count})
het laat homebot niet binnen met dat wachtwoord (status {count})
neemt niet: {value}
neemt een getal van {least} tot {most}
het heeft die instelling niet; het neemt {list}
{name} mat geen verandering
er is geen apparaat {name}
er is niemand in {room}
{name} heeft nog nooit iemand gezien; loop er eens langs
{name} is pas {count} s te horen
{reason}, en de toegang mag alleen {what}; voeg {right} toe in de tabel [{table}] van homebot.toml
{reason}, en de toegang mag alleen {what}
zo'n apparaat heeft een recht nodig dat het noemt ({reason})
{what}, en dat gaat nog {count} s voor
{value}, volgens een oude melding: nu onbereikbaar
{value}, volgens een oude melding: {age} geleden gezien
{value}, volgens een bewaarde melding: het heeft zich nog niet gemeld
{name} heet nu {what}
{name} is afgewezen en komt niet terug
{name} draait niet: {reason}
een routine of app {name} is er al; kies een andere naam, of wijzig die
{name} staat in de configuratie; wijzig het daar, en dan: {what}
niets ongedaan te maken: {name} is niet toegepast, of het is al gebeurd
van {name} is niets meer terug te halen
de sc\xE8ne {name} is er al
{name} is nu niet in huis; laat het zoals het is, of weg
er mogen {count} zijn; verwijder er eerst een
{name} is intussen gewijzigd; bekijk het, en probeer opnieuw
{name} is er al; verwijder het, of noem de gateway anders
{reason}, daarom alleen met zijn naam: {what}
het is niet gekoppeld: {what}
{name} is niet met homebot gekoppeld
de laatste herlading is geweigerd: {reason}
geen antwoord binnen {count} s
te veel codes zonder bekend effect van {issuer}
niet zolang {condition}, en de toestand van {name} is onbekend: {reason}
er is iemand in {room}: {name} was {count} s geleden aan, en sindsdien ging geen deur open
er is misschien iemand in {room}: {name} veranderde {count} s geleden, en geen opdracht verklaart het
{name} heeft een recht nodig dat het noemt ({reason}), en {issuer} heeft er geen{what}
{name} heeft een recht nodig, want {reason}, en {issuer} heeft er geen{what}
het staat niet op de lijst van onschuldige apparaten ({what})
op {value} gehouden door {holder} tot het wordt vrijgegeven
nog {count} s op {value} gehouden door {holder}
gehouden door {holder} tot het wordt vrijgegeven: {value}
nog {count} s gehouden door {holder}: {value}
{name} zei nee
niemand antwoordde binnen {count} s: dat kan op de pagina of met \`homebot answer\`
het is {time}, en stil van {start} tot {end}
er is iemand in {room}: {what}
{count} s geleden was er iemand in {room}: {what}
er is misschien iemand in {room}: {what}
onbekend of er iemand in {room} is: {reason}
{name} is {count} keer heen en weer geschakeld binnen {span} s
niet zolang {condition}: {what}
het lid {name} weigert: {reason}
{issuer} mag {name} niet bedienen, alleen: {what}
{issuer} mag {name} niet bedienen: {reason}
geen apparaat is bereikbaar: {reason}
{name} is niet bereikbaar: {reason}
{name} is nu niet op het netwerk
de verbinding met {name} ging verloren
soort: {value}
soort: {value}
het noemt zich {name}
de eenheid is {name}
het verwarmt tot {count} \xB0C
naast een ander deel: {reason}
de naam {name} zegt {what}
het model {name} zegt {what}
gateway {name} meldt zijn toestand niet
probleem van {name}
opgegeven door {name}
fouten in {name} sinds de start
geteld door {name} in de laatste tien minuten
geteld door {name} sinds de start
in quarantaine bij {name}, dat maar een deel van hun berichten leest
aantekening bij {name}
gateway {name} is {value} en verstuurt opdrachten
gateway {name} is {value} en kijkt alleen: {reason}
gateway {name} is {value} en kijkt alleen
gateway {name} is {value}: {reason}
{reason} Na de herstart van homebot: {keys}
Het bestand is als voorheen: {reason}
{count} apparaten wachten op goedkeuring en krijgen eerder niets: {list}
1 apparaat wacht op goedkeuring en krijgt eerder niets: {list}
het laatste bericht is niet verzonden: {reason}
{age} geleden gezien
gedaan: {what}
overgeslagen: niet {what}
{what} mislukte: {reason}
{value} ({count} %)
{value}, al {age}
{name} is niet veilig ({reason}), en {value}; keur het goed met {what}
de regel faalde: {what}
{count} opdrachten wachten op hun uitkomst
zijn gateway {name} is {value}: {reason}
zijn gateway {name} is {value}
{name} antwoordde niet binnen {count} s: {what}
niemand luistert naar {what}
zijn knop is niet ingedrukt binnen {count} s; druk erop en probeer het opnieuw
{name} is niet gekoppeld: {reason}
{what} is geweigerd: {reason}
{name} heeft geen beeld
{id}: {name} zag geen effect van zijn laatste opdracht; na de reparatie \`homebot trust {what}\`
{name} ({reason})
neemt: {what}
dit deel neemt: {list}
geen van zijn standen: {list}
het apparaat antwoordt: {what}
{name} is al met homebot gekoppeld
{name} hoort bij bridge {what}, die in zijn geheel gekoppeld wordt
{reason}; opnieuw over {count} s
van hier kan alleen: {value}
er is al een ruimte {name}
{name} heet al zo
{name} is met een ander systeem gekoppeld; verwijder het daar of reset het, dan {what}
{name} is verwijderd
{name} is gewijzigd
{name} is toegevoegd
{name} zei ja
{name} antwoordt niet
{name} antwoordde niet`;export{n as reasons,e as texts};
