var e=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 2nx w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 21p 727 56y 5g 1sr 1 62v 1ir 1gj 61n nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 1zo 43 1z3 17l 6k kt f38 x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv d5u 1lo py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 32g 3b8 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 2hy 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu gyh ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 3ne 18n 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3j0 89 1qr el rb 1vc n5 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 811 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 2hh 18m 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 k9 1dh a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
plant
de code is fout
het heeft het label always_ask
de tekst
fouten van het journaal
Garage
Tuin
verloren toestanden
opnieuw beginnen
{name} is gedownload ({size} kB).
Het heeft nog geen verandering gemeld.
debietsensor
het apparaat zendt alleen uit
aanmelden
luchtkwaliteit
geweigerde aankondigingen
late antwoorden
zoals het systeem
fabrikant
draait homebot al, vraag het: homebot doctor
behouden
gegevensbestand
Toevoegen
neemt meer dan 0 en tot 100 %
Terras
meldingen
Logboek
fijnstof PM1
verbroken clients
koolstofdioxide
Geldt vanaf nu.
Waarom
Aan een muur
Geen van de nieuwste {count} regels heeft deze woorden.
zwenken
In de proefweek deed je dit {done} van de {total} keer; een routine zou het in {low} tot {high} % van de gevallen goed doen.
het heeft sinds de start van homebot nog niets gemeld
navraag
artiest
homebot show DEVICE toont beide kanten; homebot forget DEVICE be\xEBindigt het
die heeft geen bewegingsmelder
activiteit
lang
heet vanaf
Er is nog geen slot, contact of alarm.
laag
nu
de Matter-server heeft geen Bluetooth; hij bereikt alleen apparaten in het netwerk
liep
ruw
tag
zijn gateway codeert zijn berichten
doorgaan zonder token
{issuer} vroeg om {values}
videospeler
fijnstof PM10
neemt een tekst
je deed het {time} eerder
wordt verzonden \u2026
Geschiedenis
de koppelingen met Apple Home
een onbekend programma
de Matter-server is afgesloten
geef het recht
geen sc\xE8ne bewaart er een
een Matter-code heeft 11 of 21 cijfers, of is een QR-code die met MT: begint
doe
het is afgebroken
Wat bekend is, en waarvan
vriezer
zijn stand is onbekend; stel die eerst in
poort
geweigerde typen
te lang
buiten alle kamers
weggegooid, te langzaam gelezen
is nat
zijn andere doelwaarde is onbekend, en beide horen samen
onbekende antwoorden
contactsensor
afgewezen aankondigingen
Alarmen
update
Hij wordt gemaakt \u2026
Het veranderde om {time}.
door {issuer}
Een zacht licht voor de weg 's nachts.
favoriet
batterij, stroom, bereik?
Niet begrepen om {time}:
beweging
Diagnose
het is niet te coderen als UTF-8
aanwezigheid
de laatste 24 uur
Een server op deze computer
titel
geen TCP-poort is vrij voor de ingebouwde broker
zijn sjabloon faalt bij deze code
verbinding
Een ventilator draait zolang de badkamer vochtig is.
verloren terugmeldingen
het moeten seconden zijn, 0 of meer
homebot opnieuw starten
Er is geen apparaat {name} (meer).
met de hand of vanzelf
homebot why APPARAAT toont de meldingen
homebot draait op proef en verstuurt niets
het effect blijft niet
zijn sjabloon geeft er niets voor
Gebruiker
het is sindsdien veranderd; bekijk het opnieuw
verzonden in \xE9\xE9n bericht aan de groep {name}
de verbinding met Home Assistant is verbroken
eindigt
Opdrachten
meter
weggegooide meldingen
ongedaan maken
meldt koolmonoxide
het maakt het huis veiliger
meldde {values}
het is te lang stil
goedkeuring
Is de behuizing open, of is het van de muur?
wachtend
na een foute code wil het een pauze; probeer het later
plattegrond met {count} kamer
daar antwoordt geen programma: start het, of verbeter het adres
rook- of CO-melder
vorstmelder
het is geen Hue-bridge; koppel de bridge waarbij het hoort
het is veranderd sinds je akkoord
{what} in de tijd, {count} punten
Er is nog niets gebeurd.
dit protocol neemt geen ruwe opdrachten; gebruik een tekstadres
Licht zolang iemand beweegt en het donker is; een lamp die al brandt of die iemand intussen schakelt, blijft zoals ze is.
Wie het nu gebruikt
niet beschikbaar
Een token geeft deze pagina haar rechten: het jouwe is de regel in owner.token, in de gegevensmap van homebot. Voor een tablet maak je er een met:
Koeler als niemand thuis is, weer warm met de eerste die komt.
, door een mens
Zoals ntfy://TOPIC of mailto://USER:PASSWORD@HOST; appriseit.com noemt ze alle.
de verbinding is gesloten
neemt een tijdstip van 1970 tot 2106
niets doen
gebruik een adreslijst op deze computer, of stel het adres in
de tabel van een gateway heeft geheimen, geen pagina leest die
instelling
installeer de nieuwere homebot weer, of: homebot restore BACKUP
Een bericht als de garage open blijft, en telkens weer.
verhelp de oorzaak in het logboek, dan: homebot app reload APP, of start homebot opnieuw
airconditioner
weggegooide delen
Nieuwe gateways beginnen bij de volgende start van homebot.
vochtsensor
Alarmen en vragen gaan via deze adressen naar telefoons, chats en e-mail.
de besturing draait niet; ze start vanzelf opnieuw, zie Systeem
mislukte opdrachten
\u2026 en nog {count}
er komen geen gebeurtenissen meer
met deze code is geen apparaat gevonden; is het klaar om te koppelen, in dit netwerk en nog nergens gekoppeld?
Gekoppeld met {count} bedieningen.
toegestaan
neemt getallen van 0 tot 360, 0 tot 100
{name} gebruiken
Wacht op je goedkeuring
sabotage
Personen
dat spreekt elkaar tegen; geef er \xE9\xE9n
Open de ramen, ga naar buiten en roep hulp
eerder
, omdat de sc\xE8ne {scene} is toegepast
opgeslagen
, omdat de sc\xE8ne {scene} ongedaan is gemaakt
sinds {time}
neemt alleen true
de naam van de computer is onbekend: verbeter het adres
Breedtegraad
verbergen in het huis
kijkt naar: {name}
Regels verschijnen hier zodra ze komen.
begint met {view}
Woonkamer
herstel of verwijder de afzender
neemt een tijdstip met tijdzone
Nodig is: {what}
tags nemen geen opdrachten
De apparaten ervan verschijnen hier.
Nog geen apparaat meldt een temperatuur.
De stofzuiger maakt eens per dag schoon als iedereen weg is.
regensensor
Een verwarming rust zolang haar raam open is.
neemt er geen
nieuwste versie
model
if: wat dan allemaal moet gelden
verloren berichten
binnen
bedtijd
niet bewaarde berichten
de client {name}
ontbrekende bibliotheek
bodemvocht
elke stap
Dit beeld is niet meer nieuw.
aankondigingen: bytes geheugen
neemt on of off
wanneer
na
quarantaines
vervang of laad hem op
een nieuwe kamer
geweigerde verzoeken
Een bewaard bericht zegt het, maar niet sinds wanneer.
drukknop
snelheid
alarmcentrale
stofzuigers die nog geen robots zijn
Er is nog geen apparaat.
boiler
QR-code
Labels
het is onbereikbaar
vochtig vanaf
donker onder
dagen
beeld van {name}
gebruiker
{energy} teruggeleverd
wijzigen
homebot draait zonder bestand; start hem in een map met homebot.toml
Elk apparaat heeft een kamer.
tijd
Slaapkamer
Nu
laatst gezien
grens
de broker antwoordt niet meer
koppelen
het heeft een code nodig
Back-up
voeg de tabel toe en start homebot opnieuw: docs/robots.md
het apparaat heeft dat deel niet meer
Druk op de knop van het apparaat en dan op \u2018koppelen\u2019.
de verbinding is verbroken
grasmaaier
nieuwste eerst
Wat deze sc\xE8ne bewaart, zegt de waarden niet.
gemiste berichten
Geen apparaat van dit huis past: {what}
verder
gevonden en nog niet gebruikt
graaf
er is niets van bekend dat een sc\xE8ne kan terughalen
Dit scherm
Kelder
het is al elders gekoppeld; verwijder het daar of herstel het
een bridge heeft geen code: druk op de knop
Het mag
weggegooid voor afwezigen
afgewezen
Voor twee derde omlaag zolang het heet is.
{least} tot {most}
Een bericht als een raam open blijft terwijl het buiten koud is.
Een bericht als een tijd veel stroom wordt gebruikt.
in rust
een sc\xE8ne heeft waarden die blijven; gebruik een routine voor wat eenmalig is
Plattegrond wordt geladen \u2026
sluit het
stand
Deuren en ramen
bereikt via
het staat in de configuratie; wijzig daar [places]
, wegens {what}
Meer bediening
het verwijst te vaak door
Naam, kamer en labels
beeld
Tijdzone
homebot wordt bevraagd \u2026
gateway
luchtbevochtiger
E\xE9n druk bij het bed: alle lichten uit, en een bericht als iets open is.
Er is nog geen routine.
Telefoon in het netwerk
frequentie
Geen vlam en geen schakelaar; open de ramen, ga naar buiten en roep hulp
Er is niets voor te stellen.
geen antwoord
geweigerde adressen
Drukste onderwerpen
Naam
andere
's Nachts koeler.
Een bericht als een plant water nodig heeft.
noem een apparaat, of zoek zoals 'light in hall'
voorgesteld door {name}
taglezer
volgende keer
ongedaan maken
meldt sabotage
Lengtegraad
Naam en plaats
sirenetoon
energie van {day}
Een stekker gaat 's nachts uit als zijn apparaat alleen wacht.
Home Assistant weigert het, of de code is fout
geweigerde verbindingen
Kant-en-klare routines
{issuer} publiceerde {text}
avond
koolmonoxide
Licht in de gang als de voordeur in het donker opengaat.
bodemsensor
Nog geen apparaat meldt vermogen of energie.
heeft een zwakke batterij
vervallen, te lang
als
vervallen, misvormd
's Ochtends en 's avonds warm.
kleurtemperatuur
Elk scherm heeft een eigen token, dat kan worden ingetrokken.
wachtende en verloren berichten
het verwijst naar een andere computer, dat wordt niet gevolgd
vervallen vragen
de adreslijst is nog niet gelezen
Energie per dag
is afgegaan
Begane grond
stille uren
maak hem van jou, of noem een andere in HOMEBOT_DATA
when: wat haar start, elk een regel
mag bedienen
Toon
De code op het apparaat
fouten van het apparatenbestand
aankondigingen: bytes te veel
Een knop schakelt een lamp.
opslaan
neemt true of false
Waarden
verzonden
uitgestelde aankondigingen
koud onder
Je gewoonten
meldt gas
tonen
Wachtwoord
instellen
dat apparaat is er niet
het heeft er geen
De eerste waarden komen over twee seconden.
lekkage
zijn beschrijving noemt de parameter niet
Is er brand? Ga naar buiten en bel de brandweer
afgeleide aankondigingen
Aanbellen wordt gemeld, en verlicht in het donker de ingang.
laatste keren
opdrachten
temperatuursensor
de kamer van het apparaat is onbekend, dus er is misschien iemand
Een apparaat zonder waarde valt weg.
Het huis is dicht
kamertemperatuur
actief
robot
token maken
meest door {name}
niet bekend: {names}
ongevaarlijk
sluit het water af
het logboek heeft elk met zijn spoor: meld of verhelp het
geen route naar die computer
het is geen Bluetooth-proxy; voeg "bluetooth_proxy:" toe aan de ESPHome-configuratie
Badkamer
de broker
Een bericht als een vriezer een tijd te warm is.
er is niets mee samengevoegd
Verborgen
staat open
Dit staat nu in homebot.toml:
het heeft geen opdracht; geef het een bestemming
Event-loop
melder
Hal
{name} goedkeuren
te veel foute codes; haal het even van de stroom
de deur is misschien open
vergrendeling
Zonder eigen meter
Alles is in orde. Let op:
Berichten
Nog geen kamer heeft een vorm. Geef haar hoeken in de tabel [places.rooms], of lees een kaart in: homebot places import BESTAND.
begint
meldt rook of hitte
tegenstrijdig
verbergen
hoog
het werd aangekondigd nadat het apparaat was goedgekeurd
je deed het niet
het kondigde er geen aan
nu uitvoeren
De code die homebot run toont, laat het eerste scherm binnen.
teruggeleverde energie
mislukte aanmeldingen
niemand is ingelicht; [notify] en het log zeggen waarom
alleen de tabel van een gateway neemt een wachtwoord of token
Schermen
de robot heeft een opdracht; zet zijn optie eerst op idle
geweigerde waarden
Het was zo bij de eerste melding.
Het testbericht is verzonden.
waar dit scherm is
altijd vragen
genegeerde aankondigingen
, onderweg
Waarden, verloop, feiten
Ze bewaart de huidige waarden van:
Hij bevat alles wat homebot bewaart, maar geen wachtwoorden.
die stand heeft deze doelwaarde niet
Een volle stip is aan, open of bezet.
Om hem terug te zetten:
deze homebot bewaart niets
homebot show APPARAAT
map voor gegevens
er zijn twee verschillende apparaten nodig
Zeven dagen
tracker
met de hand
Home Assistant sloot de verbinding
de code is fout; weet je het zeker, probeer het dan nog eens
ingekorte kenmerken
de gateway kijkt alleen; sta opdrachten toe onder Systeem, Apparaten
Het huis is open
niet hier
Veranderd sinds de vorige goedkeuring:
kant-en-klare routines
meldt een probleem
er is niets terug te nemen, of het bestand is sindsdien veranderd
zoeken \u2026
Zijn laatste gebeurtenis, die geen toestand is:
het gebeurt \xE9\xE9n keer en blijft niet
naar het huis
horizontaal zwenken
Open dit \xE9\xE9n keer op het scherm; het wordt alleen nu getoond:
De plaats geeft zonsopgang en zonsondergang; die blijft hier.
de robot heeft zijn toestand nog niet gemeld
voorinstelling
het schakelt het alarm uit
sensor
de huidige waarden nemen
Een lamp brandt van schemering tot bedtijd als er iemand thuis is.
gereserveerde topics
geweigerde apparaten
{name} is gekoppeld.
verwarming
niet verbonden
blijft
Persoon
weggegooid (QoS 0)
helderheid
since moet voor until liggen
Er draait geen app.
neemt een tijdstip zonder tijdzone
Routines worden geladen \u2026
wacht een minuut, kijk dan in het logboek
meerdere namen voor \xE9\xE9n kenmerk: misschien meerdere apparaten
het wil er meer tegelijk, dat kan niet
huishouden
verdieping
het apparaat kan alleen uit, zoals een kookplaat voor de veiligheid
nog niet verbonden
het profiel van het apparaat heeft er geen frame voor
Goedkeuring staat deze opdrachten toe:
het token geldt niet meer, of hoort bij iets anders
door een ander programma
terug
geheim
bel
schrijven \u2026
Knopen links publiceren onderwerpen, knopen rechts abonneren zich erop.
, vanzelf
vervallen termijnen
Traagste ontvanger
de thermostaat staat in een andere stand; wijzig die eerst
, een echo
je deed het {time} later
aannemen
HomeKit heeft er geen dienst voor
Gevonden:
niet bereikbaar
Het certificaat dat je apparaten moeten vertrouwen
verbeteren, dan: homebot config check
signaalsterkte
Na vijf minuten toont het een gedimde klok en wat open is. Het adres van dit scherm:
Het is zo sinds homebot het kent.
het is niet verzonden
elektriciteitsmeter
gestopt
rolluik of gordijn
Graaf wordt geladen \u2026
Token of code
deurslot
verzonden in \xE9\xE9n bericht aan de sc\xE8ne {name}
, door een ander programma
er is nog niets gewijzigd
ventilatorstand
Alles is in orde.
neemt een getal dat het formaat kan schrijven
Er wordt gestookt met een raam open
het is geen JPEG, PNG, GIF of WebP tot 2 MiB
{time} geleden
weggegooid, te groot
verbeter het apparaat of zijn aankondiging
stand
jij, door {what}
als ze start terwijl ze loopt
Apparaten
Weggelaten, want geheim: {files}
testbericht sturen
Er is nog niets geteld.
homebot kan hier niet zelf herstarten; start het opnieuw
vertraging van de event-loop
het logboek en homebot journal zeggen meer
start homebot opnieuw na een nieuwe tabel: docs/protocols.md
nieuwe routine
frequentie
zoeken
geweigerde opdrachten
de Matter-server is te traag
daarna
te laat met
betwist
{name} mag apparaten bedienen
geef er een, zoals level 40
druk
elke keer
watermelder
waterklep
ochtend
ontvangen
geef elk apparaat een eigen kenmerk in zijn aankondigingen; tot dan hebben zijn delen deze namen
allen thuis
lekkage
lang open
lift
bewegingsmelder
geweigerde topics
geen opdracht stuurt mensen naar huis
kijken
verloren
antwoorden
Druk nu op de knop: nog {count} s
CoAP kent die methode niet
Laatst hier
do: haar stappen, elk een regel
plattegrond met {count} kamers
zonder kamer
tegelijk
batterij laadt
Licht en een bericht als er water is waar het niet hoort.
{name} verwijderen
druksensor
back-up maken
het heeft geen adres
geweigerde berichten
{nodes} knopen en {topics} onderwerpen
dubbelzinnige aankondigingen
vluchtige stoffen
Van die tijd is niets bewaard.
kijken en bedienen
lichtsensor
rechten
Apps
zwakke batterij
stroomonderbreker
Meteen een bericht als een deur opengaat en niemand thuis is.
geweigerde abonnementen
afwijzen
Vandaag
veranderd naar {values}
zendt wat zijn aankondiging niet verklaart
Token
kamer
{issuer} werd geweigerd: {reason}
Onderwerp
homebot weet wie er thuis is door telefoons in het netwerk en door trackers.
afwezig
Lampen gaan 's avonds aan en uit als niemand thuis is.
Een bericht als de wasmachine klaar is.
zijn conventie faalde
verlaagd
, door het apparaat of een mens
in deze browser bewaren
mislukte meldingen
batterij, stroom, bereik? Is het voorgoed weg: homebot forget DEVICE
droogt
Werkkamer
Wachtrijen en verliezen
Niets dat gemeten wordt staat aan.
Wat je hier verandert, toont elk scherm.
de lamellen gaan alleen open (100) en dicht (0)
vervallen, te veel
donker
Zonder TLS installeert een browser geen app: tls = true in [door].
versie
mislukte verbindingen
robotstofzuiger
Kleuren
onleesbare waarden
een druk op zijn knop
afmelden
vanzelf
nog {count} s
er is geen adres: in [notify] staat er geen
foute configuratie
Een lamp wordt twintig minuten lang lichter voor je opstaat.
Er is geen beeld.
opnieuw verzonden
toon wat goedkeuring van {name} toestaat
homebot zoekt in de geschiedenis van vier weken wat je steeds weer doet, en kijkt een week toe voordat het dat voorstelt.
de apparaten van het huis zijn nog niet bekend
het is niet te volgen
Rook, water, beweging
Keuken
Alle lichten gaan uit als iedereen weg is.
Adres
de eigenaar heeft het niet goedgekeurd
debiet
rook of hitte
open sinds
, omdat {device} {values} meldde
deze routine {names} laten bedienen
stand
Taal
Omlaag bij schemering, omhoog in de ochtend.
alles
het netwerk nam het aan
gewoonten zoeken
het hoort niet bij wat de toegang mag bedienen
{energy} kWh op andere zulke dagen
normaal
luchtkwaliteitssensor
berichten per seconde
bezig
nu niet bekend
fouten
licht
vergeten stoorders
een van zijn waarden is onbekend
er wordt al een ander apparaat gekoppeld
In de app Woning: +, Voeg accessoire toe, en scan dit of typ de code.
homebot place APPARAAT KAMER
aankondigingen`,n=`a person must agree: {reason}
whether {name} is on is unknown; say on or off
no device fits {name}; {reason}
did you mean {name}?
nothing near {name} may be commanded; left out: {what}
not while {condition}: {name} is unknown
it takes a text that matches {what}
it takes a {what} in ISO 8601 format
a command has 1 to {count}
it must be a text of {count} characters at most
there are {count} already; take some back
no import stated it; {reason}
there are {count} decisions already; undo some
it has no announcement {name}; it has {what}
the bridge for HomeKit cannot listen on {name}: {reason}
{reason}; \`at_night\` (\`--night\`) allows it
somebody sleeps in {room} now
nothing was changed, as the values to put back cannot be kept: {reason}
there is no device or picture {name}
no connection was made within {count} seconds
it has no characteristic {name}
no device is reachable: {reason}
another proxy has its address {name}
the interface {name} cannot be used for {value} multicast: {reason}
no CoAP endpoint can be opened: {reason}
no {value} multicast on the interface {name}: {reason}
mDNS cannot be used on {name}: {reason}
it did not announce {name} as a command topic
the embedded broker cannot listen: {reason}
it wants another encryption; {reason}
it wants {what}, and {name} is configured
it wants {what}, which is not supported
it wants encryption; {reason}
it wants another password; {reason}
it wants {what}; {reason}
it does not encrypt; {reason}
it takes a text of {least} to {most} characters
it takes a text of at most {count} characters
it takes a text of at most {what}
its template failed: {what}
its template {what}
it cannot be encoded as {what}
Home Assistant did not greet within {count} s
it would heat to {least} \xB0C, and cool to {most} \xB0C
HAP status {count}
the bridge of {name} is not connected
node {count} was commissioned, but the gateway has max_nodes already
the Matter gateway has no device {name}
the device answered with the status {what}
the device answered error {what}
the address {name} is unknown: {reason}
the content type {name} is not understood
the observation of {name} ended
no copies can be made in {name}: {reason}
it takes {what}, and no change
it offers no {what}
it has no script {name}; a table [[gateways.ble.proxies]] installs it
the robot takes no orders in its mode {what}
the table {name} is not among those that a page may change: {what}
the key {name} loads a program or a file; only a person writes it into the file
the right {name} is none that you may give; use: homebot token new
no backup has a byte {count}; begin with 0, which makes one
the change {name} of the layout has no names
the address {name} is not in the file any more; look at it again
gateway {name} is away: {reason}
service {name} did not answer within {count} s; whether it acted is unknown
refused ({value}): {reason}
changed back after {count} s, {value}
not sent: {reason}
contradicted: {reason}
the host name cannot be looked up now ({what})
{name} has the lift
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
{name} takes no commands that homebot knows
{count} devices fit {name}; at most {most} may be commanded
{what} was not sent to {name}: {reason}
{what} was sent to {name}: {reason}
{what} of {name}: {reason}
{name} has {what} already
{name} has no part
{name} cannot be reached with TLS: {reason}
{count} Bluetooth proxies are connected already
{name} takes longer than {count} s for one answer
{name} is not known at any endpoint
{name} has no address of HTTP
{name} has no address
{name} answers no requests
{name} takes no message
{name} ended the stream of events
{name} cannot be announced as {what}: {reason}
{name}: {count} commands are waiting for {what} already
{name} cannot be opened: {reason}; {what}
{name} cannot be opened: {reason}
{name} was not set: {reason}
{name} is paired by the code on it: {what}
{name} is commissioned already
{name} is behind the bridge {what} ({id}); only the bridge can be removed
{name} does not answer the Matter server
{name} has not described itself yet
{what} of {name} cannot be set
{name} cannot be written: {reason}
{name} cannot be moved aside: {reason}
{name} is not open
{name} cannot be copied: {reason}
{name} cannot be recreated: {reason}
{name} of {what} cannot be kept in a file of its own
{name} = {what} is no value of TOML; texts need quotes
{name} cannot be a name: give up to {count} printable characters
{name} cannot be {what}: {reason}
iemand moet het goedvinden: {reason}
onbekend of {name} aan is; zeg on of off
geen apparaat past bij {name}; {reason}
bedoelde je {name}?
niets bij {name} is te bedienen; weggelaten: {what}
niet zolang {condition}: {name} is onbekend
neemt een tekst van de vorm {what}
neemt {what} volgens ISO 8601
een opdracht heeft er 1 tot {count}
het moet een tekst van hoogstens {count} tekens zijn
er zijn er al {count}; trek er enkele in
geen import noemt het; {reason}
er zijn al {count} beslissingen; maak er enkele ongedaan
het heeft geen aankondiging {name}; het heeft {what}
de bridge voor HomeKit kan niet luisteren op {name}: {reason}
{reason}; \`at_night\` (\`--night\`) staat het toe
in {room} slaapt nu iemand
er is niets veranderd, want de oude waarden zijn niet te bewaren: {reason}
er is geen apparaat of beeld {name}
geen verbinding binnen {count} s
het heeft geen kenmerk {name}
geen apparaat is bereikbaar: {reason}
een andere proxy heeft zijn adres {name}
de interface {name} is niet te gebruiken voor {value}-multicast: {reason}
er is geen CoAP-eindpunt te openen: {reason}
geen {value}-multicast op de interface {name}: {reason}
mDNS is niet te gebruiken op {name}: {reason}
het kondigde {name} niet aan als onderwerp voor opdrachten
de ingebouwde broker kan niet luisteren: {reason}
het wil een andere versleuteling; {reason}
het wil {what}, en {name} is ingesteld
het wil {what}, dat kan niet
het wil versleuteling; {reason}
het wil een ander wachtwoord; {reason}
het wil {what}; {reason}
het versleutelt niet; {reason}
neemt een tekst van {least} tot {most} tekens
neemt een tekst van hoogstens {count} tekens
neemt een tekst van hoogstens {what}
zijn sjabloon faalt: {what}
zijn sjabloon {what}
het is niet te coderen als {what}
Home Assistant meldde zich niet binnen {count} s
het zou tot {least} \xB0C verwarmen en tot {most} \xB0C koelen
HAP-status {count}
de bridge van {name} is niet verbonden
node {count} is in gebruik, maar de gateway heeft al max_nodes
de Matter-gateway heeft geen apparaat {name}
het apparaat antwoordt met de status {what}
het apparaat antwoordt met de fout {what}
het adres {name} is onbekend: {reason}
het inhoudstype {name} wordt niet begrepen
het volgen van {name} is gestopt
in {name} zijn geen kopie\xEBn te maken: {reason}
neemt {what}, en geen verandering
het biedt geen {what}
het heeft geen script {name}; een tabel [[gateways.ble.proxies]] installeert het
de robot neemt geen opdrachten in modus {what}
een pagina mag de tabel {name} niet wijzigen, alleen: {what}
de sleutel {name} laadt een programma of bestand; schrijf hem zelf
het recht {name} mag je niet geven; gebruik: homebot token new
geen back-up heeft een byte {count}; begin bij 0
de wijziging {name} noemt niets
het adres {name} staat niet meer in het bestand; kijk er opnieuw naar
gateway {name} is weg: {reason}
{name} antwoordde niet binnen {count} s; onbekend of het gebeurde
geweigerd ({value}): {reason}
ging na {count} s terug, {value}
niet verzonden: {reason}
tegengesproken: {reason}
de naam van de computer is nu niet op te zoeken ({what})
{name} heeft de lift
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
{name} antwoordde niet
{name} kent geen opdrachten die homebot kent
{count} apparaten passen bij {name}; hoogstens {most} tegelijk
{what} is niet naar {name} verzonden: {reason}
{what} is naar {name} verzonden: {reason}
{what} van {name}: {reason}
{name} heeft al {what}
{name} heeft geen deel
{name} is niet bereikbaar met TLS: {reason}
{count} Bluetooth-proxy's zijn al verbonden
{name} doet langer dan {count} s over \xE9\xE9n antwoord
{name} is bij geen eindpunt bekend
{name} heeft geen HTTP-adres
{name} heeft geen adres
{name} beantwoordt geen vragen
{name} neemt geen bericht
{name} be\xEBindigde de gebeurtenissen
{name} is niet aan te kondigen als {what}: {reason}
{name}: {count} opdrachten wachten al op {what}
{name} is niet te openen: {reason}; {what}
{name} is niet te openen: {reason}
{name} is niet ingesteld: {reason}
{name} wordt gekoppeld met de code erop: {what}
{name} is al in gebruik genomen
{name} zit achter de bridge {what} ({id}); alleen de bridge is te verwijderen
{name} antwoordt de Matter-server niet
{name} heeft zich nog niet beschreven
{what} van {name} is niet in te stellen
{name} is niet te schrijven: {reason}
{name} is niet opzij te leggen: {reason}
{name} is niet open
{name} is niet te kopi\xEBren: {reason}
{name} is niet opnieuw te maken: {reason}
{name} van {what} past niet in een eigen bestand
{name} = {what} is geen waarde van TOML; teksten hebben aanhalingstekens
{name} kan geen naam zijn: geef tot {count} afdrukbare tekens
{name} werkt niet ({what}): {reason}`;export{n as reasons,e as texts};
