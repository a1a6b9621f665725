var e=`12j 1nt xg kp 7jj e9 1ca 7b 6gn o4 1jy 16u 187 3l 43 1ys dl 2gl 9k l 16l dy 1tl mb 18g 1 2g jv ht 1ey b2g 2o9 57v 56 77i 19j 2ce eq 2dy f9 2u5 25s 6sh 2u 34u ds 6z 8u 1ck 15z dw fw tk 9a 3z9 dz 2d 2re 1sy 26q 4il 5th 9s 28y f4 fs 2do afh 8f 3i5 cv 61l 2hu 1 yw 2so 21l qk 1pk f8 49v h0 2nv 50y 1ws 50y 2qv sp qi 1p8 16f qf cf sm 8r ds 1m5 fv 6a 4pw 2p6 143 1bj 2ur 1px 3lz cz 18x 1x9 3eg 2dx 7on 1cp 3c 34y 11h 169 eh df da 8ls 1q9 x4 3xe 14o c7w 3ah 5z 5k 32g s0 l7 9fy 1xr 44j 27j ta g3 ep qk 6mh 12p 1og 1xv 15x 49 el 23l 328 5i 100 327 1wm 1xk 1ap 2t4 2v1 5x 2k 4s 2h8 1kc 2g6 2i9 2no r4 6rc 1v6 1q0 i9 32t 1av 42x xs 13 kd 112 3bm 1n4 1e2 b2 p6 1i3 wv 1w6 3qg 175 3jk g7 41r 2g7 3il 1pz 2g1 ro 3wh 1qt 26e oz 3rr 1tg 1c f3 6yx al 4so 17l 41w 6dv 1kc 1nd cu 1rj 7fv 59c 140 1be 3cm dw 4go 1li zh 4yb 68y c2 5d0 31 2er 3sa 43i 1kz 34i 4w8 13r 22m ak9 2ou 1q1 6gs 2nw v4 hm 3in ay dx 54a 8ph 8yp 1n2 226 5j4 3kr 8p c9 1ax 4x xt 2z1 2b9 1lj 7q3 8ma 7vl cel 24 5el xa mf 3wt 3xk 2qm 6vi hx 6bj 6o 4on byf 4ut t9 2h 405 2ht 1x7 1pt 1eb 4zo 6rz 9yz 53o a8 ow 1cc 3gv 3ej 7a 3r 226 ub 9jc 1v 2cw 8b p9 17l 149 13y 59b 2bs 3pw 1sj 5ho 1ho 17t 8mb fn 2jv rf c0p 2s 14d hy 2nz 1gt r4 1qs 31i 2z9 klp 18a 207 tj tg 3q 3g 2bl ji c 2s9 4x6 6xf 11b 14h 2e8 emi 2tj cz yw 1tn aa 34y 4ut 2y0 1y 2tz gr 2ny 60j 3jv 1nb th 1ew 5jo 7z 1pz 6mz 2pe 2mr tx 1ce 7d7 44g 1w8 x 2fx 11r a9 2m1 4ci 133 9l 72c 6i vc 5um nr 2dc 483 pv 3s 7gs e5 308 l6 447 ui 23k 233 1fi ca lq 2ct vi 23l bq 1ds z0 d6 31k 3ca 4i2 k2 4sq 2g3 1vq 3oz 2a8 26q 341 1r9 28q 344 3d0 1lc 28 13 3je oz z7 206 2gi cj x9 8u 4k5 2pp 7t 37h 3kx rh 2nq 84j 1cx 1bw 4sv 3y 4dy ox 1jt 1dk 1d0 1h 46 4ig r7 392 132 3ok 27c 33y 7j 3ql z4 1tg bg 303 11 28r 1tv 3e 976 6e4 40v bmc 1xq zn 5sd 4so 3u 5lg 38 4j1 3tr 13q 350 8xl 15c 1o8 18z 4m3 af jf 3yp 2vr 2q3 sw 176 7y f 2f4 14r 18b 27i 1q7 56i 2k2 38y 5g3 2s9 lu 1xh xr we 4f6 1ox r 179 ed6 18o 1lc 9r 1 2nd bd 59v 3yl 3zn o 13q 23e ij 9xx gb qp bu to 2ub a1g 11h 1b4 1p3 1cl 40g 1f3 7n3 32e zz ha 1sv 3h6 1pm 2gp 1kl 3qy 1f2 3qi 2d3 23v 5ta 5p 31l 2qw 9nh 5n 39d 28q 16x 3fr 58u 1e3 aa 2c 1h 38r y ep 5tz 3it pv q4 tn k3 18d akw 1ki 1kq 5on is 1nx 16s 19d 3f 2hr 3fi 5up 2zs 2m7 82 3pd 20r 3x7 6f 3lr 5j1 w3 171 kp h 1nr 8ry 16b 17q 42u vd 3po 11x z 26y 9x0 5jo l2 24d 4aw bm 6y 4et 125 35n 1ta 71r 1c5 2y 2f b8 27u 113 4rf 4f5 958 2el 1n7 2d4 32f 7wy 73a 1l1 3ly 4dj 8jf 4n fb 1ua 18k xh
het antwoordde niet op tijd
Garage
Tuin
meldt sabotage
foute configuratie
gateway
watermelder
Zeven dagen
Toevoegen
de robot heeft een opdracht; zet zijn optie eerst op idle
homebot draait op proef en verstuurt niets
Logboek
fijnstof PM1
de tabel van een gateway heeft geheimen, geen pagina leest die
Opdrachten
Waarom
de broker antwoordt niet meer
afmelden
navraag
fouten van het apparatenbestand
laatste keren
als ze start terwijl ze loopt
laag
nu
liep
ruw
maak hem van jou, of noem een andere in HOMEBOT_DATA
tag
Is er brand? Ga naar buiten en bel de brandweer
meldde {values}
bereikt via
draait homebot al, vraag het: homebot doctor
geen route naar die computer
when: wat haar start, elk een regel
voorinstelling
daar antwoordt geen programma: start het, of verbeter het adres
ongedaan maken
bodemvocht
terug
eerder
een van zijn waarden is onbekend
regensensor
is afgegaan
het wil er meer tegelijk, dat kan niet
Vandaag
sinds >
droogt
normaal
Token
de kamer van het apparaat
Onderwerp
vertraging van de event-loop
Taal
Nodig is: $
meldingen
geweigerde aankondigingen
zwakke batterij
installeer de nieuwere homebot weer, of: homebot restore BACKUP
Nieuwe gateways beginnen bij de volgende start van homebot.
stofzuigers die nog geen robots zijn
het is bezig
back-up maken
# gebruiken
{issuer} publiceerde {text}
een bridge heeft geen code: druk op de knop
vervang of laad hem op
de kamer van het apparaat is onbekend, dus er is misschien iemand
rook of hitte
geef er een, zoals level 40
Een bewaard bericht zegt het, maar niet sinds wanneer.
Geldt vanaf nu.
Personen
verbergen
hoog
het heeft het label always_ask
de toestand van het huis
te laat met
neemt een tijdstip zonder tijdzone
Het is zo sinds homebot het kent.
vorstmelder
het netwerk nam het aan
Lengtegraad
vanzelf
Een token geeft deze pagina haar rechten: het jouwe is de regel in owner.token, in de gegevensmap van homebot. Voor een tablet maak je er een met:
huishouden
Plattegrond wordt geladen \u2026
robot
Weggelaten, want geheim: {files}
afgewezen aankondigingen
Zoals ntfy://TOPIC of mailto://USER:PASSWORD@HOST; appriseit.com noemt ze alle.
, door een ander programma
er is niets mee samengevoegd
fouten van het journaal
door een ander programma
mislukte verbindingen
fabrikant
vervallen, te lang
homebot why APPARAAT toont de meldingen
Terras
neemt getallen van 0 tot 360, 0 tot 100
homebot weet wie er thuis is door telefoons in het netwerk en door trackers.
> geleden
stille uren
{least} tot {most}
Ze bewaart de huidige waarden van:
stand
is nat
aankondigingen
neemt true of false
ventilatorstand
volgende keer
Het huis is open
toon wat goedkeuring van # toestaat
if: wat dan allemaal moet gelden
airconditioner
het is niet verzonden
door {issuer}
Dit staat nu in homebot.toml:
Naam en plaats
Knopen links publiceren onderwerpen, knopen rechts abonneren zich erop.
de naam van de computer is onbekend: verbeter het adres
mislukte aanmeldingen
gestopt
Begane grond
geweigerde topics
verdieping
gebruik een adreslijst op deze computer, of stel het adres in
Geschiedenis
elke keer
contactsensor
geweigerde adressen
sluit het
neemt een tijdstip van 1970 tot 2106
het staat in de configuratie; wijzig daar [places]
stand
niet verbonden
Telefoon in het netwerk
koolstofdioxide
verbergen in het huis
Open de ramen, ga naar buiten en roep hulp
neemt alleen true
het heeft net andere topics voor opdrachten aangekondigd, misschien die van een ander apparaat; probeer het opnieuw
Dit scherm
{nodes} knopen en {topics} onderwerpen
Adres
kleurtemperatuur
geweigerde typen
tracker
de lamellen gaan alleen open (100) en dicht (0)
$ in de tijd, * punten
vluchtige stoffen
niet beschikbaar
zijn geheugen is vol
laatst gezien
die stand heeft deze doelwaarde niet
gekopieerd
koppelen
aankondigingen: bytes te veel
er is niets terug te nemen, of het bestand is sindsdien veranderd
opnieuw gemaakt
niets doen
zijn sjabloon geeft er niets voor
die heeft geen bewegingsmelder
homebot zoekt in de geschiedenis van vier weken wat je steeds weer doet, en kijkt een week toe voordat het dat voorstelt.
homebot show APPARAAT
het heeft sinds de start van homebot nog niets gemeld
de koppelingen met Apple Home
Geen vlam en geen schakelaar; open de ramen, ga naar buiten en roep hulp
nieuwe routine
rolluik of gordijn
Er is nog geen slot, contact of alarm.
plattegrond met * kamers
een getal
Tijdzone
Elk scherm heeft een eigen token, dat kan worden ingetrokken.
De apparaten ervan verschijnen hier.
quarantaines
neemt er geen
druk
instelling
bezig
Dit beeld is niet meer nieuw.
Een server op deze computer
Een apparaat zonder waarde valt weg.
hij wacht hoogstens een minuut op apparaten van voorheen; probeer het opnieuw
in deze browser bewaren
het heeft geen opdracht; geef het een bestemming
geweigerde apparaten
deze routine {names} laten bedienen
luchtkwaliteitssensor
Je gewoonten
de verbinding met Home Assistant is verbroken
Alarmen en vragen gaan via deze adressen naar telefoons, chats en e-mail.
het kondigde er geen aan
het apparaat antwoordt met een fout
de robot heeft zijn toestand nog niet gemeld
berichten per seconde
het adres van een stream, zoals een radio
drukknop
Zijn laatste gebeurtenis, die geen toestand is:
mislukte opdrachten
Laatst hier
opgeslagen
rook- of CO-melder
debietsensor
aankondigingen: bytes geheugen
signaalsterkte
verder
zoeken
homebot kan hier niet zelf herstarten; start het opnieuw
Rook, water, beweging
een eindig getal
model
geen adres
geweigerde waarden
Er is nog niets gebeurd.
antwoorden
meerdere namen voor \xE9\xE9n kenmerk: misschien meerdere apparaten
{issuer} vroeg om {values}
Is de behuizing open, of is het van de muur?
de verbinding is gesloten
zijn bridge bereikt het niet
grasmaaier
Het veranderde om >.
melder
het apparaat zendt alleen uit
Niet begrepen om >:
stroomonderbreker
lichtsensor
Druk op de knop van het apparaat en dan op \u2018koppelen\u2019.
het logboek en homebot journal zeggen meer
geef homebot een map waarin het mag schrijven (HOMEBOT_DATA), of start het met --ephemeral
vochtsensor
verzonden in \xE9\xE9n bericht aan de groep #
alles
druksensor
Apps
Home Assistant sloot de verbinding
Nog geen apparaat meldt vermogen of energie.
verbroken clients
nog niet verbonden
waterklep
na een foute code wil het een pauze; probeer het later
bluetoothd draait niet
niet bekend: {names}
niemand is ingelicht; [notify] en het log zeggen waarom
update
Alles is in orde.
Na vijf minuten toont het een gedimde klok en wat open is. Het adres van dit scherm:
verzonden in \xE9\xE9n bericht aan de sc\xE8ne #
boiler
aanwezigheid
# opnieuw starten
afwijzen
ongedaan maken
snelheid
alarmcentrale
elektriciteitsmeter
Wat bekend is, en waarvan
een andere sleutel
Werkkamer
Zonder eigen meter
geen opdracht stuurt mensen naar huis
noem password_file of password_env in [gateways.mdns.drivers.shelly]
graaf
Er is niets voor te stellen.
Er is geen apparaat # (meer).
frequentie
het apparaat heeft dat deel niet meer
# is gekoppeld.
Er wordt gestookt met een raam open
Veranderd sinds de vorige goedkeuring:
do: haar stappen, elk een regel
het is geen Hue-bridge; koppel de bridge waarbij het hoort
geweigerde abonnementen
zendt wat zijn aankondiging niet verklaart
nieuwste versie
{energy} teruggeleverd
waar dit scherm is
wanneer
de gateway kijkt alleen; sta opdrachten toe onder Systeem, Apparaten
Zonder TLS installeert een browser geen app: tls = true in [door].
homebot draait zonder bestand; start hem in een map met homebot.toml
Van die tijd is niets bewaard.
deurslot
token maken
je deed het niet
Routines worden geladen \u2026
HomeKit heeft er geen dienst voor
gereserveerde topics
voortgang van de update
er is nog niets gewijzigd
geef de sleutel die zijn ESPHome-configuratie onder "api: encryption:" heeft als key_file, of geen
Wacht op je goedkeuring
geen antwoord
Back-up
De code op het apparaat
Toon
geen sc\xE8ne bewaart er een
Home Assistant weigert het, of de code is fout
noem een apparaat, of zoek zoals 'light in hall'
doe
Alarmen
geweigerde verzoeken
videospeler
ontvangen
Nog geen kamer heeft een vorm. Geef haar hoeken in de tabel [places.rooms], of lees een kaart in: homebot places import BESTAND.
geef elk apparaat een eigen kenmerk in zijn aankondigingen; tot dan hebben zijn delen deze namen
de code is fout
zoeken \u2026
het neemt geen opdrachten aan, het meldt alleen
een sc\xE8ne heeft waarden die blijven; gebruik een routine voor wat eenmalig is
ongevaarlijk
er is geen D-Bus; onder Linux moeten bluetoothd en de systeembus draaien
elke stap
tegenstrijdig
onbekende antwoorden
er is geen weg voor opdrachten
gebruiker
te veel foute codes; haal het even van de stroom
poort
Energie per dag
tijden en het huis
gevonden en nog niet gebruikt
Er draait geen app.
opnieuw verzonden
zijn sjabloon faalt bij deze code
Graaf wordt geladen \u2026
verloren berichten
opnieuw beginnen
het is niet te volgen
een onbekend programma
Apparaten
gegevensbestand
meest door #
frequentie
wijzigen
on of off
alleen een mens antwoordt, op de pagina
het apparaat is in gebruik genomen, maar zijn attributen waren niet te lezen
er wordt al een ander apparaat gekoppeld
met deze code is geen apparaat gevonden; is het klaar om te koppelen, in dit netwerk en nog nergens gekoppeld?
afgeleide aankondigingen
dat spreekt elkaar tegen; geef er \xE9\xE9n
homebot show DEVICE toont beide kanten; homebot forget DEVICE be\xEBindigt het
Hal
media
sluit het water af
het is onbereikbaar
het apparaat kan alleen uit, zoals een kookplaat voor de veiligheid
geen route naar dat netwerk
een ander wachtwoord
de laatste 24 uur
homebot wordt bevraagd \u2026
Er is nog niets geteld.
het is te lang stil
te lang
het is afgebroken
temperatuursensor
heeft een zwakke batterij
de besturing draait niet; ze start vanzelf opnieuw, zie Systeem
batterij, stroom, bereik?
afgewezen
Kleuren
kamers reinigen
neemt een tijdstip met tijdzone
het is sindsdien veranderd; bekijk het opnieuw
alleen een app of routine kan er een hebben, door zijn sleutel \`act\`
er komen geen gebeurtenissen meer
energie van {day}
genegeerde aankondigingen
de thermostaat staat in een andere stand; wijzig die eerst
Naam
True of False
niet bereikbaar
zijn conventie faalde
niet hier
Breedtegraad
zwenken
je deed het > later
Hij wordt gemaakt \u2026
homebot place APPARAAT KAMER
Diagnose
gewoonten zoeken
QR-code
Nu
toegestaan
zonder reden te noemen
verbeteren, dan: homebot config check
batterij laadt
start homebot opnieuw na een nieuwe tabel: docs/protocols.md
naar het huis
Deuren en ramen
Traagste ontvanger
Wachtrijen en verliezen
de Matter-server is afgesloten
Het was zo bij de eerste melding.
die vraag is er niet meer; \`homebot answer\` toont de open vragen
kijkt naar: #
voeg de tabel toe en start homebot opnieuw: docs/robots.md
meldt rook of hitte
, vanzelf
Persoon
behouden
allen thuis
Nog geen apparaat meldt een temperatuur.
een wachtwoord
Labels
mislukte meldingen
Drukste onderwerpen
lekkage
daarna
de Matter-server is te traag
de adreslijst is nog niet gelezen
wacht een minuut, kijk dan in het logboek
vervallen termijnen
weggegooide meldingen
vervallen, misvormd
Berichten
de robot weet niet waar hij is; lokaliseer hem eerst
een andere versleuteling
sensor
een nieuwe kamer
de client #
sinds de start van deze gateway heeft het niet gezegd wat het kan; misschien slaapt het: wek het, en probeer het opnieuw
het duurde te lang
Hij bevat alles wat homebot bewaart, maar geen wachtwoorden.
favoriet
in rust
beeld
vergeten stoorders
sabotage
# mag apparaten bedienen
voorgesteld door #
goedkeuring
verloren toestanden
Schermen
In de proefweek deed je dit {done} van de {total} keer; een routine zou het in {low} tot {high} % van de gevallen goed doen.
neemt meer dan 0 en tot 100 %
lang open
zijn andere doelwaarde is onbekend, en beide horen samen
, door het apparaat of een mens
rechten
activiteit
, een echo
, door een mens
het is geen JPEG, PNG, GIF of WebP tot 2 MiB
wachtende en verloren berichten
er is niets van bekend dat een sc\xE8ne kan terughalen
zijn gateway codeert zijn berichten
veranderd naar {values}
nu uitvoeren
Een volle stip is aan, open of bezet.
de broker
het is veranderd sinds je akkoord
stand
wachtend
instellen
koolmonoxide
ingekorte kenmerken
luchtbevochtiger
zijn stand is onbekend; stel die eerst in
Het huis is dicht
Alles is in orde. Let op:
een wachtwoord alleen zou onversleuteld gaan naar wie zich zo noemt: voeg "api: encryption:" toe aan zijn ESPHome-configuratie en geef key_file, of zijn vaste IP-adres als allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
een druk op zijn knop
robotstofzuiger
staat open
verloren terugmeldingen
deze homebot bewaart niets
Aan een muur
nu niet bekend
Verborgen
sinds de start van deze gateway geen geldige aankondiging; herstart het apparaat of zijn bridge, of wacht
De plaats geeft zonsopgang en zonsondergang; die blijft hier.
Open dit \xE9\xE9n keer op het scherm; het wordt alleen nu getoond:
De eerste waarden komen over twee seconden.
doorgaan zonder token
de code is fout; weet je het zeker, probeer het dan nog eens
since moet voor until liggen
geheim
er is geen adres: in [notify] staat er geen
Token of code
Elk apparaat heeft een kamer.
begint met {view}
Kant-en-klare routines
\`homebot find\` toont wat past
Wat je hier verandert, toont elk scherm.
De code die homebot run toont, laat het eerste scherm binnen.
debiet
CoAP kent die methode niet
Het mag
betwist
, omdat {device} {values} meldde
meldt koolmonoxide
dubbelzinnige aankondigingen
ontbrekende bibliotheek
de tekst
uitgestelde aankondigingen
verbinding
het is niet te coderen als UTF-8
In de app Woning: +, Voeg accessoire toe, en scan dit of typ de code.
herstel of verwijder de afzender
dit protocol neemt geen ruwe opdrachten; gebruik een tekstadres
kant-en-klare routines
fouten
Gekoppeld met * bedieningen.
tint (0 tot 360) en verzadiging (0 tot 100), zoals 0,100 voor rood of 240,50 voor lichtblauw
Niets dat gemeten wordt staat aan.
wordt verzonden \u2026
zoals het systeem
tags nemen geen opdrachten
gemiste berichten
geweigerde verbindingen
\u2026 en nog *
het is al elders gekoppeld; verwijder het daar of herstel het
lekkage
lift
, onderweg
kijken
verloren
geef het recht
Naam, kamer en labels
Gebruiker
waarden
het profiel van het apparaat heeft er geen frame voor
Geen van de nieuwste * regels heeft deze woorden.
een tekst
Slaapkamer
Wat deze sc\xE8ne bewaart, zegt de waarden niet.
buiten alle kamers
het werd aangekondigd nadat het apparaat was goedgekeurd
kamertemperatuur
Er is nog geen routine.
vergrendeling
Badkamer
late antwoorden
altijd vragen
vervallen vragen
als
Regels verschijnen hier zodra ze komen.
bewegingsmelder
het heeft geen adres
dit homebot heeft geen routines
verhelp het zoals het logboek zegt: homebot app reload APP, homebot gateway restart NAME
het heeft er geen
licht
met de hand of vanzelf
# is gedownload ({size} kB).
, omdat de sc\xE8ne {scene} ongedaan is gemaakt
niet bewaarde berichten
Keuken
horizontaal zwenken
Het heeft nog geen verandering gemeld.
Wie het nu gebruikt
de eigenaar heeft het niet goedgekeurd
Event-loop
Waarden, verloop, feiten
Waarden
kijken en bedienen
de verbinding is verbroken
vervallen, te veel
versleuteling
map voor gegevens
het heeft een code nodig
neemt kamers, maar heeft er nog geen genoemd
teruggeleverde energie
de ingebouwde broker kan niet luisteren: alle poorten zijn bezet
het schakelt het alarm uit
verwarming
Om hem terug te zetten:
sirenetoon
nog * s
titel
Kelder
de apparaten van het huis zijn nog niet bekend
, omdat de sc\xE8ne {scene} is toegepast
kamer
# verwijderen
afwezig
het weigert het wachtwoord van password_file of password_env in [gateways.mdns.drivers.shelly]
bodemsensor
actief
het maakt het huis veiliger
met de hand
het hoort niet bij wat de toegang mag bedienen
de huidige waarden nemen
weggegooid, te langzaam gelezen
verbeter het apparaat of zijn aankondiging
het moeten seconden zijn, 0 of meer
nieuwste eerst
Gevonden:
luchtkwaliteit
een Matter-code heeft 11 of 21 cijfers, of is een QR-code die met MT: begint
het verloop is nog niet begonnen, of wordt niet bewaard; \`homebot doctor\` zegt waarom
batterij, stroom, bereik? Is het voorgoed weg: homebot forget DEVICE
, wegens $
alleen de tabel van een gateway neemt een wachtwoord of token
neemt een getal dat het formaat kan schrijven
mag bedienen
Het testbericht is verzonden.
je deed het > eerder
fijnstof PM10
Het certificaat dat je apparaten moeten vertrouwen
taglezer
dat apparaat is er niet
Er is nog geen apparaat.
de Matter-server heeft geen Bluetooth; hij bereikt alleen apparaten in het netwerk
plattegrond met * kamer
{issuer} werd geweigerd: &
de bridge antwoordt iets onbekends
Woonkamer
{energy} kWh op andere zulke dagen
aannemen
Meer bediening
het logboek heeft elk met zijn spoor: meld of verhelp het
Wachtwoord
donker
# goedkeuren
weggegooid voor afwezigen
het verwijst naar een andere computer, dat wordt niet gevolgd
tegelijk
aanmelden
weggegooid (QoS 0)
opdrachten
het effect blijft niet
homebot opnieuw starten
meldt gas
Druk nu op de knop: nog * s
niets
artiest
de deur is misschien open
het gebeurt \xE9\xE9n keer en blijft niet
het is geen Bluetooth-proxy; voeg "bluetooth_proxy:" toe aan de ESPHome-configuratie
zonder kamer
weggegooid, te groot
geweigerde opdrachten
versie
Goedkeuring staat deze opdrachten toe:
jij, door $
geweigerde berichten
onleesbare waarden
beeld van #
testbericht sturen
het verwijst te vaak door
meldt een probleem
Geen apparaat van dit huis past: $
schrijven \u2026
het token geldt niet meer, of hoort bij iets anders
er zijn twee verschillende apparaten nodig
opslaan
verzonden
tonen`,n=`# asks, so another answers: use the owner's token, and give programs their own
# must ask itself
the question is over: &
the Matter server answered with error *
the bridge for HomeKit cannot listen on #, port *: &
it is not paired yet; $, with the code that is printed on it
it has no part #; it has $
its < is never below {least}, and it has no switch
it wants <; &
it takes percent; did you mean < %? To set $ %: #
it takes a text that matches $ of *
a number in $
by $? Its < is unknown; give a value, such as #
it has no room: $
# was switched back and forth * times within {span} s
# was switched back and forth * times within {span} s; with a token (\`homebot token new\`) a program may more often
a restart would lose this, as it was not written: &
# is in use by a running homebot
# is stated in the configuration; change [places] there
devices were placed in it: $; place them elsewhere first
no command gave it to #, which has <
no command stated the room of #
there is no device #, and no command stated its room
there may be * with {most} parts in all; remove one first
too many tests: wait for * s
approve it with \`homebot approve ^\`, and {advice}
if it can hurt nobody, \`homebot tag add ^ #\`, otherwise {advice}
there is no proposal * now; \`homebot suggest\` lists them
# is unsafe (&), and it changed since the owner approved it: $; approve it with \`homebot approve ^\`
the ^ # is not open
put the key that its ESPHome configuration has under "api: encryption: key:" into a file, and name that in [gateways.mdns.drivers.esphome.devices."^"] as key_file
put the one that its ESPHome configuration has under "api: password:" into a file, and name that in [gateways.mdns.drivers.esphome.devices."^"] as password_file
add "api: encryption:" to its ESPHome configuration, or remove the key in [gateways.mdns.drivers.esphome.devices."^"]
it is announced at <, and its allow_plaintext_at is $; &
a person must agree: &
whether # is on is unknown; say on or off
no device fits #; &
did you mean #?
nothing near # may be commanded; left out: $
not while {condition}: < is unknown
it takes a text that matches $
it takes a $ in ISO 8601 format
a command has 1 to *
it must be a text of * characters at most
there are * already; take some back
no import stated it; &
there are * decisions already; undo some
it has no announcement #; it has $
&; \`at_night\` (\`--night\`) allows it
somebody sleeps in ~ now
nothing was changed, as the values to put back cannot be kept: &
there is no device or picture #
no connection was made within * seconds
it has no characteristic #
no device is reachable: &
another proxy has its address #
the interface # cannot be used for < multicast: &
the ^ # cannot be opened: &
the ^ # cannot be <: &
no CoAP endpoint can be opened: &
no < multicast on the interface #: &
mDNS cannot be used on #: &
$ of [#] is for the address that is there; give it again with the other one
$ of [#] names a secret of this computer; only a person writes it into the file
it is longer than * characters
the embedded broker cannot listen: port * is taken
it did not announce # as a command topic
the embedded broker cannot listen: &
it wants $, and # is configured
it wants $, which is not supported
it does not encrypt; &
it takes a text of {least} to {most} characters
it takes a text of at most * characters
it takes a text of at most $
its template failed: $
its template $
it cannot be encoded as $
Home Assistant did not greet within * s
it would heat to {least} \xB0C, and cool to {most} \xB0C
HAP status *
the bridge of # is not connected
node * was commissioned, but the gateway has max_nodes already
the Matter gateway has no device #
the device answered with the status $
the device answered error $
the address # is unknown: &
the content type # is not understood
the observation of # ended
no copies can be made in #: &
it takes &, and no change
it offers no $
it has no script #; a table [[gateways.ble.proxies]] installs it
the robot takes no orders in its mode $
the table # is not among those that a page may change: $
the key # loads a program or a file; only a person writes it into the file
the right # is none that you may give; use: homebot token new
no backup has a byte *; begin with 0, which makes one
the change # of the layout has no names
the address # is not in the file any more; look at it again
gateway # starts again
gateway # is away: &
service # did not answer within * s; whether it acted is unknown
refused (<): &
changed back after * s, <
not sent: &
contradicted: &
the host name cannot be looked up now ($)
# has the lift
< closed the connection
# is not connected: &
# is not connected
# did not answer within * s
# is asleep; try again once it is awake
# is unavailable in Home Assistant
Home Assistant has no entity for the part # any more
# has no driver; \`homebot doctor\` names those that cannot be used
the certificate of # is not trusted
$: the server answered *, it may work later
the server answered *
it wants a password (status *)
it does not let homebot in with the password that is configured (status *)
it takes no <
it takes a number from {least} to {most}
it has no such setting; it takes {list}
# measured no change
there is no device with the id #
nobody is in ~
# has never detected anybody; walk past it once
# has been heard for only * s
&, and the scope of the client is $; add {right} to that, in the table [{table}] of homebot.toml
&, and the scope of the client is $
such a device needs a right that names it (&)
$, which outranks leases for * s more
<, by an old report: it is unreachable now
<, by an old report: last seen {age} ago
<, by a kept report: it has not reported itself yet
renamed # to $
rejected #; it is not proposed again
# does not run: &
a routine or app # is there already; choose another name, or edit that one
# is in the configuration; change it there, and then: $
there is nothing to undo: # was not applied, or was undone since
nothing that # changed is left to bring back
there is a scene # already
# is not in the house now; leave it as it is, or out
there may be *; remove one first
# was changed meanwhile; look at it, and try again
# is there already; remove it, or give the gateway another name
&, so it is exported by its name alone: $
it is not paired: $
# is not paired with homebot
the last reload was refused: &
no answer within * s
too many codes without a known effect by {issuer}
not while {condition}, and the state of # is unknown: &
somebody is in ~: # was on * s ago, and no door has been opened since
somebody may be in ~: # changed * s ago, and no command explains it
# needs a right that names it (&), and {issuer} has none; {advice}
# needs a right, because &, and {issuer} has none; {advice}
it is not on the list of harmless devices ($)
held at < by {holder} until it is released
held at < by {holder} for * s more
held < by {holder} until it is released
held < by {holder} for * s more
# said no
nobody answered within * s: a person does on the page, or with \`homebot answer\`
it is >, and quiet from {start} to {end}
the robot # is on its way in ~ or to it
somebody is in ~: $
somebody was in ~ * s ago: $
somebody may be in ~: $
it is unknown whether anybody is in ~: &
not while {condition}: $
its member # is refused it: &
{issuer} may not command #, only: $
{issuer} may not command #: &
no device can be reached: &
# cannot be reached: &
# is not on the network now
the connection to # was lost
it is a <
it is an <
it calls itself #
its unit is #
it heats up to * \xB0C
beside another part: &
the name # says $
the model # says $
gateway # does not report its state
problem of #
given up by #
failures in # since it started
counted by # in the last ten minutes
counted by # since it started
quarantined by #, which reads only some of their messages
note on #
gateway # is < and sends commands
gateway # is < and only observes: &
gateway # is < and only observes
it crashed ({error}) and starts again in >; at once: {text}
gateway # is <: &
&; restart homebot for the changes of {keys}
the file is as it was: &
* devices wait for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
1 device waits for approval, and nothing is sent before (\`homebot approve DEVICE\`): {list}
the last notification was not sent: &
last seen {age} ago
done: $
held back: not $
$ failed: &
< (* %)
<, for {age}
# is unsafe (&), and <; approve it with \`homebot approve ^\`
the policy failed: $
* commands wait for their outcome
its gateway # is <: &
its gateway # is <
# did not answer $ within * s
no client subscribes to $
its button was not pressed within * s; press it and try again
pairing # was refused: &
$ was refused: &
# has no picture
^: # saw no effect of its last command; \`homebot trust $\` once it is repaired
it takes &
this part takes {list}
none of its modes is that: {list}
the device answered &
# is paired with homebot already
# is behind the bridge $, which is paired as a whole
&; try again in * s
it can only be turned < from here
there is a room # already
# is called that already
#: it is paired with another controller; remove it there, or reset it, then $
removed #
changed #
added #
# said yes
# does not answer
# did not answer
# takes no commands that homebot knows
* devices fit #; at most {most} may be commanded
$ was not sent to #: &
$ was sent to #: &
$ of #: &
# has $ already
# has no part
# cannot be reached with TLS: &
* Bluetooth proxies are connected already
# takes longer than * s for one answer
# is not known at any endpoint
# has no address of HTTP
# has no address
# answers no requests
# takes no message
# ended the stream of events
# cannot be announced as $: &
#: * commands are waiting for $ already
# cannot be opened: &
# was not set: &
# is paired by the code on it: $
# is commissioned already
# is behind the bridge $ (^); only the bridge can be removed
# does not answer the Matter server
# has not described itself yet
$ of # cannot be set
# cannot be written: &
# cannot be moved aside: &
# cannot be copied: &
# of $ cannot be kept in a file of its own
# = $ is no value of TOML; texts need quotes
# cannot be a name: give up to * printable characters
# cannot be $: &
it is >, and people sleep from {start} to {end}
\`$ --act ^\` gives one
$ act = [^] gives one
# at $: &
$ in steps of *
$ or more seconds
{least} to {most} s
# (&)
there is no < #; &
# vraagt, dus een ander antwoordt: neem het token van de eigenaar, en geef programma's een eigen
# moet zelf vragen
de vraag is voorbij: &
de Matter-server antwoordt met fout *
de bridge voor HomeKit kan #, poort * niet openen: &
het is nog niet gekoppeld; $, met de code erop
het heeft geen deel #, wel $
< komt nooit onder {least}, en het heeft geen schakelaar
het wil <; &
neemt procenten; bedoelde je < %? Voor $ %: #
neemt een tekst van de vorm $ (*)
een getal in $
met $? < is onbekend; noem een waarde, zoals #
het heeft geen kamer: $
# is in {span} s * keer heen en weer geschakeld
# is in {span} s * keer heen en weer geschakeld; met een token (\`homebot token new\`) mag een programma vaker
een herstart zou dit verliezen, want het is niet geschreven: &
# is in gebruik bij een draaiend homebot
# staat in de configuratie; wijzig daar [places]
er staan apparaten in: $; zet ze eerst ergens anders
geen opdracht gaf het aan #, dat < heeft
geen opdracht noemde de kamer van #
er is geen apparaat #, en geen opdracht noemde zijn kamer
er mogen * met {most} delen zijn; verwijder er eerst een
te veel tests: wacht * s
keur het goed met \`homebot approve ^\`, en {advice}
als het niemand kan deren, \`homebot tag add ^ #\`, anders {advice}
voorstel * is er niet meer; \`homebot suggest\` toont ze
# is niet ongevaarlijk (&), en het is veranderd sinds je goedkeuring: $; keur het goed met \`homebot approve ^\`
^ # is niet open
zet wat zijn ESPHome-configuratie onder "api: encryption: key:" heeft in een bestand, en noem dat in [gateways.mdns.drivers.esphome.devices."^"] als key_file
zet wat zijn ESPHome-configuratie onder "api: password:" heeft in een bestand, en noem dat in [gateways.mdns.drivers.esphome.devices."^"] als password_file
voeg "api: encryption:" toe aan zijn ESPHome-configuratie, of verwijder de sleutel in [gateways.mdns.drivers.esphome.devices."^"]
het kondigt zich aan op <, maar allow_plaintext_at is $; &
iemand moet het goedvinden: &
onbekend of # aan is; zeg on of off
geen apparaat past bij #; &
bedoelde je #?
niets bij # is te bedienen; weggelaten: $
niet zolang {condition}: < is onbekend
neemt een tekst van de vorm $
neemt $ volgens ISO 8601
een opdracht heeft er 1 tot *
het moet een tekst van hoogstens * tekens zijn
er zijn er al *; trek er enkele in
geen import noemt het; &
er zijn al * beslissingen; maak er enkele ongedaan
het heeft geen aankondiging #; het heeft $
&; \`at_night\` (\`--night\`) staat het toe
in ~ slaapt nu iemand
er is niets veranderd, want de oude waarden zijn niet te bewaren: &
er is geen apparaat of beeld #
geen verbinding binnen * s
het heeft geen kenmerk #
geen apparaat is bereikbaar: &
een andere proxy heeft zijn adres #
de interface # is niet te gebruiken voor <-multicast: &
^ # is niet te openen: &
^ # kan niet worden <: &
er is geen CoAP-eindpunt te openen: &
geen <-multicast op de interface #: &
mDNS is niet te gebruiken op #: &
$ van [#] hoort bij het huidige adres; geef het opnieuw met het nieuwe
$ van [#] noemt een geheim van deze computer; alleen een mens schrijft het in het bestand
het is langer dan * tekens
de ingebouwde broker kan niet luisteren: poort * is bezet
het kondigde # niet aan als onderwerp voor opdrachten
de ingebouwde broker kan niet luisteren: &
het wil $, en # is ingesteld
het wil $, dat kan niet
het versleutelt niet; &
neemt een tekst van {least} tot {most} tekens
neemt een tekst van hoogstens * tekens
neemt een tekst van hoogstens $
zijn sjabloon faalt: $
zijn sjabloon $
het is niet te coderen als $
Home Assistant meldde zich niet binnen * s
het zou tot {least} \xB0C verwarmen en tot {most} \xB0C koelen
HAP-status *
de bridge van # is niet verbonden
node * is in gebruik, maar de gateway heeft al max_nodes
de Matter-gateway heeft geen apparaat #
het apparaat antwoordt met de status $
het apparaat antwoordt met de fout $
het adres # is onbekend: &
het inhoudstype # wordt niet begrepen
het volgen van # is gestopt
in # zijn geen kopie\xEBn te maken: &
neemt &, en geen verandering
het biedt geen $
het heeft geen script #; een tabel [[gateways.ble.proxies]] installeert het
de robot neemt geen opdrachten in modus $
een pagina mag de tabel # niet wijzigen, alleen: $
de sleutel # laadt een programma of bestand; schrijf hem zelf
het recht # mag je niet geven; gebruik: homebot token new
geen back-up heeft een byte *; begin bij 0
de wijziging # noemt niets
het adres # staat niet meer in het bestand; kijk er opnieuw naar
gateway # start opnieuw
gateway # is weg: &
# antwoordde niet binnen * s; onbekend of het gebeurde
geweigerd (<): &
ging na * s terug, <
niet verzonden: &
tegengesproken: &
de naam van de computer is nu niet op te zoeken ($)
# heeft de lift
< sloot de verbinding
# is niet verbonden: &
# is niet verbonden
# antwoordde niet binnen * s
# slaapt; probeer het als het wakker is
# is niet beschikbaar in Home Assistant
Home Assistant heeft geen entiteit meer voor #
# heeft geen driver; \`homebot doctor\` noemt wat niet bruikbaar is
het certificaat van # wordt niet vertrouwd
$: de server antwoordt *, later lukt het misschien
de server antwoordt *
het vraagt een wachtwoord (status *)
het laat homebot niet binnen met dat wachtwoord (status *)
neemt niet: <
neemt een getal van {least} tot {most}
het heeft die instelling niet; het neemt {list}
# mat geen verandering
er is geen apparaat #
er is niemand in ~
# heeft nog nooit iemand gezien; loop er eens langs
# is pas * s te horen
&, en de toegang mag alleen $; voeg {right} toe in de tabel [{table}] van homebot.toml
&, en de toegang mag alleen $
zo'n apparaat heeft een recht nodig dat het noemt (&)
$, en dat gaat nog * s voor
<, volgens een oude melding: nu onbereikbaar
<, volgens een oude melding: {age} geleden gezien
<, volgens een bewaarde melding: het heeft zich nog niet gemeld
# heet nu $
# is afgewezen en komt niet terug
# draait niet: &
een routine of app # is er al; kies een andere naam, of wijzig die
# staat in de configuratie; wijzig het daar, en dan: $
niets ongedaan te maken: # is niet toegepast, of het is al gebeurd
van # is niets meer terug te halen
de sc\xE8ne # is er al
# is nu niet in huis; laat het zoals het is, of weg
er mogen * zijn; verwijder er eerst een
# is intussen gewijzigd; bekijk het, en probeer opnieuw
# is er al; verwijder het, of noem de gateway anders
&, daarom alleen met zijn naam: $
het is niet gekoppeld: $
# is niet met homebot gekoppeld
de laatste herlading is geweigerd: &
geen antwoord binnen * s
te veel codes zonder bekend effect van {issuer}
niet zolang {condition}, en de toestand van # is onbekend: &
er is iemand in ~: # was * s geleden aan, en sindsdien ging geen deur open
er is misschien iemand in ~: # veranderde * s geleden, en geen opdracht verklaart het
# heeft een recht nodig dat het noemt (&), en {issuer} heeft er geen; {advice}
# heeft een recht nodig, want &, en {issuer} heeft er geen; {advice}
het staat niet op de lijst van onschuldige apparaten ($)
op < gehouden door {holder} tot het wordt vrijgegeven
nog * s op < gehouden door {holder}
gehouden door {holder} tot het wordt vrijgegeven: <
nog * s gehouden door {holder}: <
# zei nee
niemand antwoordde binnen * s: dat kan op de pagina of met \`homebot answer\`
het is >, en stil van {start} tot {end}
robot # rijdt in ~ of ernaartoe
er is iemand in ~: $
* s geleden was er iemand in ~: $
er is misschien iemand in ~: $
onbekend of er iemand in ~ is: &
niet zolang {condition}: $
het lid # weigert: &
{issuer} mag # niet bedienen, alleen: $
{issuer} mag # niet bedienen: &
geen apparaat is bereikbaar: &
# is niet bereikbaar: &
# is nu niet op het netwerk
de verbinding met # ging verloren
soort: <
soort: <
het noemt zich #
de eenheid is #
het verwarmt tot * \xB0C
naast een ander deel: &
de naam # zegt $
het model # zegt $
gateway # meldt zijn toestand niet
probleem van #
opgegeven door #
fouten in # sinds de start
geteld door # in de laatste tien minuten
geteld door # sinds de start
in quarantaine bij #, dat maar een deel van hun berichten leest
aantekening bij #
gateway # is < en verstuurt opdrachten
gateway # is < en kijkt alleen: &
gateway # is < en kijkt alleen
vastgelopen ({error}), start over > opnieuw; meteen: {text}
gateway # is <: &
& Na de herstart van homebot: {keys}
Het bestand is als voorheen: &
* apparaten wachten op goedkeuring en krijgen eerder niets: {list}
1 apparaat wacht op goedkeuring en krijgt eerder niets: {list}
het laatste bericht is niet verzonden: &
{age} geleden gezien
gedaan: $
overgeslagen: niet $
$ mislukte: &
< (* %)
<, al {age}
# is niet veilig (&), en <; keur het goed met \`homebot approve ^\`
de regel faalde: $
* opdrachten wachten op hun uitkomst
zijn gateway # is <: &
zijn gateway # is <
# antwoordde niet binnen * s: $
niemand luistert naar $
zijn knop is niet ingedrukt binnen * s; druk erop en probeer het opnieuw
# is niet gekoppeld: &
$ is geweigerd: &
# heeft geen beeld
^: # zag geen effect van zijn laatste opdracht; na de reparatie \`homebot trust $\`
neemt: &
dit deel neemt: {list}
geen van zijn standen: {list}
het apparaat antwoordt: &
# is al met homebot gekoppeld
# hoort bij bridge $, die in zijn geheel gekoppeld wordt
&; opnieuw over * s
van hier kan alleen: <
er is al een ruimte #
# heet al zo
# is met een ander systeem gekoppeld; verwijder het daar of reset het, dan $
# is verwijderd
# is gewijzigd
# is toegevoegd
# zei ja
# antwoordt niet
# antwoordde niet
# kent geen opdrachten die homebot kent
* apparaten passen bij #; hoogstens {most} tegelijk
$ is niet naar # verzonden: &
$ is naar # verzonden: &
$ van #: &
# heeft al $
# heeft geen deel
# is niet bereikbaar met TLS: &
* Bluetooth-proxy's zijn al verbonden
# doet langer dan * s over \xE9\xE9n antwoord
# is bij geen eindpunt bekend
# heeft geen HTTP-adres
# heeft geen adres
# beantwoordt geen vragen
# neemt geen bericht
# be\xEBindigde de gebeurtenissen
# is niet aan te kondigen als $: &
#: * opdrachten wachten al op $
# is niet te openen: &
# is niet ingesteld: &
# wordt gekoppeld met de code erop: $
# is al in gebruik genomen
# zit achter de bridge $ (^); alleen de bridge is te verwijderen
# antwoordt de Matter-server niet
# heeft zich nog niet beschreven
$ van # is niet in te stellen
# is niet te schrijven: &
# is niet opzij te leggen: &
# is niet te kopi\xEBren: &
# van $ past niet in een eigen bestand
# = $ is geen waarde van TOML; teksten hebben aanhalingstekens
# kan geen naam zijn: geef tot * afdrukbare tekens
# werkt niet ($): &
het is >, en er wordt geslapen van {start} tot {end}
\`$ --act ^\` geeft er een
$ act = [^] geeft er een
# op $: &
$ in stappen van *
$ seconden of meer
{least} tot {most} s
# (&)
er is geen < #; &`;export{n as reasons,e as texts};
