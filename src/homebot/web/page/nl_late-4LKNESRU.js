var e=`24e 5rm 1ts 2b7 5w 1j0 y4 rn 1pz 40 2gq 5up d1 1c9 25s 105 nh 10b w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 93w 56y 5g 1sr 1 62v 1ir 1gj av 5qs nf 23f 4mf hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 ot 1pj 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 8q 1qy 43 1z3 17l 6k kt 9zn 53l x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 2se 16a 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 2pb 3tv 18j sp 9b 1l2 q0 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv 4z0 14d 72h 1lo py 29q 2os 38b 18q 1e6 4be 66n 9jc 53k e0 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 4l 17l 9nf 38l sw 4ab 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 36 2es 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 3d1 5bi fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 159 1t0 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 3i8 ir bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu 8zc 7z5 ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 1o2 yq 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 2nz zf g2 sl 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1ls 9o 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 60 19n 6z ow 1y4 1kw 89 1qr el rb 1vc n5 39k k2 1s5 1xu 5y3 1hy 4l2 bp1 pi lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 5e8 2mt 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o 3uo 6f2 jx 4dl 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 1mc 179 4d k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 7 230 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 5j 1ih 1s5 w0 1ax cx 1nh ih 2hh 18m 6h sj 17y al q7 3x1 1fo 2wz 1df 6qm 5c1 k9 1dh 6l a1n h ca 13y 10c 4rg 35s 25z rh z0 123 ru 2aw 2kn 3j5 6n 29h 1d6 3p8 1yg 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
plant
de code is fout
het heeft het label always_ask
het apparaat is in gebruik genomen, maar zijn attributen waren niet te lezen
de tekst
fouten van het journaal
Garage
het neemt geen opdrachten aan, het meldt alleen
tint (0 tot 360) en verzadiging (0 tot 100), zoals 0,100 voor rood of 240,50 voor lichtblauw
Tuin
verloren toestanden
opnieuw beginnen
# is gedownload ({size} kB).
Het heeft nog geen verandering gemeld.
debietsensor
een andere sleutel
alleen een app of routine kan er een hebben, door zijn sleutel \`act\`
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
Geen van de nieuwste * regels heeft deze woorden.
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
je deed het > eerder
wordt verzonden \u2026
Geschiedenis
de koppelingen met Apple Home
een onbekend programma
de Matter-server is afgesloten
geef het recht
geen sc\xE8ne bewaart er een
het apparaat antwoordt met een fout
een Matter-code heeft 11 of 21 cijfers, of is een QR-code die met MT: begint
doe
de kamer van het apparaat
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
er is geen D-Bus; onder Linux moeten bluetoothd en de systeembus draaien
Hij wordt gemaakt \u2026
Het veranderde om >.
door {issuer}
Een zacht licht voor de weg 's nachts.
favoriet
batterij, stroom, bereik?
Niet begrepen om >:
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
het verloop is nog niet begonnen, of wordt niet bewaard; \`homebot doctor\` zegt waarom
homebot opnieuw starten
Er is geen apparaat # (meer).
met de hand of vanzelf
homebot why APPARAAT toont de meldingen
homebot draait op proef en verstuurt niets
het effect blijft niet
media
zijn sjabloon geeft er niets voor
Gebruiker
het is sindsdien veranderd; bekijk het opnieuw
verzonden in \xE9\xE9n bericht aan de groep #
de verbinding met Home Assistant is verbroken
eindigt
Opdrachten
meter
weggegooide meldingen
ongedaan maken
meldt koolmonoxide
er is geen weg voor opdrachten
het maakt het huis veiliger
meldde {values}
het is te lang stil
goedkeuring
Is de behuizing open, of is het van de muur?
wachtend
na een foute code wil het een pauze; probeer het later
plattegrond met * kamer
daar antwoordt geen programma: start het, of verbeter het adres
rook- of CO-melder
vorstmelder
het is geen Hue-bridge; koppel de bridge waarbij het hoort
het is veranderd sinds je akkoord
$ in de tijd, * punten
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
het heeft net andere topics voor opdrachten aangekondigd, misschien die van een ander apparaat; probeer het opnieuw
airconditioner
weggegooide delen
Nieuwe gateways beginnen bij de volgende start van homebot.
hij wacht hoogstens een minuut op apparaten van voorheen; probeer het opnieuw
zijn bridge bereikt het niet
vochtsensor
Alarmen en vragen gaan via deze adressen naar telefoons, chats en e-mail.
de besturing draait niet; ze start vanzelf opnieuw, zie Systeem
mislukte opdrachten
\u2026 en nog *
er komen geen gebeurtenissen meer
met deze code is geen apparaat gevonden; is het klaar om te koppelen, in dit netwerk en nog nergens gekoppeld?
Gekoppeld met * bedieningen.
toegestaan
neemt getallen van 0 tot 360, 0 tot 100
# gebruiken
Wacht op je goedkeuring
sabotage
Personen
dat spreekt elkaar tegen; geef er \xE9\xE9n
Open de ramen, ga naar buiten en roep hulp
eerder
, omdat de sc\xE8ne {scene} is toegepast
opgeslagen
, omdat de sc\xE8ne {scene} ongedaan is gemaakt
sinds >
neemt alleen true
de naam van de computer is onbekend: verbeter het adres
Breedtegraad
verbergen in het huis
kijkt naar: #
Regels verschijnen hier zodra ze komen.
begint met {view}
Woonkamer
herstel of verwijder de afzender
neemt een tijdstip met tijdzone
Nodig is: $
tags nemen geen opdrachten
De apparaten ervan verschijnen hier.
Nog geen apparaat meldt een temperatuur.
De stofzuiger maakt eens per dag schoon als iedereen weg is.
regensensor
Een verwarming rust zolang haar raam open is.
\`homebot find\` toont wat past
noem password_file of password_env in [gateways.mdns.drivers.shelly]
neemt er geen
nieuwste versie
model
if: wat dan allemaal moet gelden
verloren berichten
binnen
bedtijd
waarden
niet bewaarde berichten
de client #
ontbrekende bibliotheek
het duurde te lang
bodemvocht
elke stap
Dit beeld is niet meer nieuw.
aankondigingen: bytes geheugen
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
beeld van #
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
Geen apparaat van dit huis past: $
het weigert het wachtwoord van password_file of password_env in [gateways.mdns.drivers.shelly]
verder
gevonden en nog niet gebruikt
het is bezig
tijden en het huis
graaf
er is niets van bekend dat een sc\xE8ne kan terughalen
Dit scherm
Kelder
het is al elders gekoppeld; verwijder het daar of herstel het
een bridge heeft geen code: druk op de knop
Het mag
weggegooid voor afwezigen
afgewezen
het adres van een stream, zoals een radio
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
, wegens $
Meer bediening
het verwijst te vaak door
Naam, kamer en labels
het antwoordde niet op tijd
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
een ander wachtwoord
Naam
andere
's Nachts koeler.
Een bericht als een plant water nodig heeft.
noem een apparaat, of zoek zoals 'light in hall'
voorgesteld door #
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
zonder reden te noemen
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
een eindig getal
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
die vraag is er niet meer; \`homebot answer\` toont de open vragen
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
meest door #
niet bekend: {names}
ongevaarlijk
sluit het water af
het logboek heeft elk met zijn spoor: meld of verhelp het
geen route naar die computer
het is geen Bluetooth-proxy; voeg "bluetooth_proxy:" toe aan de ESPHome-configuratie
Badkamer
opnieuw gemaakt
de broker
alleen een mens antwoordt, op de pagina
Een bericht als een vriezer een tijd te warm is.
er is niets mee samengevoegd
Verborgen
staat open
Dit staat nu in homebot.toml:
het heeft geen opdracht; geef het een bestemming
Event-loop
melder
Hal
# goedkeuren
te veel foute codes; haal het even van de stroom
de deur is misschien open
vergrendeling
Zonder eigen meter
Alles is in orde. Let op:
Berichten
True of False
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
sinds de start van deze gateway geen geldige aankondiging; herstart het apparaat of zijn bridge, of wacht
er is niets terug te nemen, of het bestand is sindsdien veranderd
zoeken \u2026
Zijn laatste gebeurtenis, die geen toestand is:
een wachtwoord alleen zou onversleuteld gaan naar wie zich zo noemt: voeg "api: encryption:" toe aan zijn ESPHome-configuratie en geef key_file, of zijn vaste IP-adres als allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
het gebeurt \xE9\xE9n keer en blijft niet
naar het huis
horizontaal zwenken
Open dit \xE9\xE9n keer op het scherm; het wordt alleen nu getoond:
De plaats geeft zonsopgang en zonsondergang; die blijft hier.
de robot heeft zijn toestand nog niet gemeld
voorinstelling
zijn geheugen is vol
geen adres
het schakelt het alarm uit
sensor
de huidige waarden nemen
Een lamp brandt van schemering tot bedtijd als er iemand thuis is.
gereserveerde topics
de bridge antwoordt iets onbekends
geweigerde apparaten
# is gekoppeld.
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
geef homebot een map waarin het mag schrijven (HOMEBOT_DATA), of start het met --ephemeral
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
je deed het > later
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
verzonden in \xE9\xE9n bericht aan de sc\xE8ne #
, door een ander programma
er is nog niets gewijzigd
ventilatorstand
Alles is in orde.
neemt een getal dat het formaat kan schrijven
Er wordt gestookt met een raam open
het is geen JPEG, PNG, GIF of WebP tot 2 MiB
> geleden
weggegooid, te groot
verbeter het apparaat of zijn aankondiging
stand
jij, door $
als ze start terwijl ze loopt
Apparaten
Weggelaten, want geheim: {files}
testbericht sturen
Er is nog niets geteld.
on of off
homebot kan hier niet zelf herstarten; start het opnieuw
geen route naar dat netwerk
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
# mag apparaten bedienen
geef er een, zoals level 40
druk
elke keer
watermelder
waterklep
ochtend
ontvangen
bluetoothd draait niet
een wachtwoord
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
Druk nu op de knop: nog * s
CoAP kent die methode niet
Laatst hier
do: haar stappen, elk een regel
een tekst
plattegrond met * kamers
zonder kamer
tegelijk
batterij laadt
Licht en een bericht als er water is waar het niet hoort.
# verwijderen
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
geef de sleutel die zijn ESPHome-configuratie onder "api: encryption:" heeft als key_file, of geen
kamer
{issuer} werd geweigerd: &
Onderwerp
homebot weet wie er thuis is door telefoons in het netwerk en door trackers.
afwezig
Lampen gaan 's avonds aan en uit als niemand thuis is.
Een bericht als de wasmachine klaar is.
zijn conventie faalde
verlaagd
, door het apparaat of een mens
sinds de start van deze gateway heeft het niet gezegd wat het kan; misschien slaapt het: wek het, en probeer het opnieuw
in deze browser bewaren
mislukte meldingen
een andere versleuteling
batterij, stroom, bereik? Is het voorgoed weg: homebot forget DEVICE
droogt
Werkkamer
Wachtrijen en verliezen
Niets dat gemeten wordt staat aan.
Wat je hier verandert, toont elk scherm.
de lamellen gaan alleen open (100) en dicht (0)
vervallen, te veel
een getal
dit homebot heeft geen routines
donker
Zonder TLS installeert een browser geen app: tls = true in [door].
versie
mislukte verbindingen
robotstofzuiger
Kleuren
versleuteling
onleesbare waarden
een druk op zijn knop
gekopieerd
afmelden
vanzelf
nog * s
niets
er is geen adres: in [notify] staat er geen
foute configuratie
Een lamp wordt twintig minuten lang lichter voor je opstaat.
de toestand van het huis
opnieuw verzonden
toon wat goedkeuring van # toestaat
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
aankondigingen`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# was switched back and forth * times within {span} s$
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
the ^ # cannot be <: &
no CoAP endpoint can be opened: &
no < multicast on the interface #: &
mDNS cannot be used on #: &
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
# is in {span} s * keer heen en weer geschakeld$
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
^ # kan niet worden <: &
er is geen CoAP-eindpunt te openen: &
geen <-multicast op de interface #: &
mDNS is niet te gebruiken op #: &
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
