var n=`1c 1 aqg 2oh gn9 4 xj m4 7w 3a 2hc xg 1jt mb 6u2 1c7 2dr fsj 1du 3g5 35h 25q 3f8 58 8i6 9hb 12yl 4lo 18i 1q 320 h96 ir 5bl 1a2 1qb 57t 8b 1er d3x i46 bkg tx 8fp 1p5 75 g82 1zw 1i3 1vc a3g dq4 1mj 18i 50n cd 56y e9 3th p0 37a 38 qv dfu 41 8qh k0 1nu 5vw 1x8 41q 300 iiz 4 4z 4e7 3ua 3tz f8 7ep 24m 3ic 4w2 iy 1aw 18g k04 4k7 6m8 b4 3os 142 41v 1k8 lr 1wu az0 dmb yq1 8a7 ft 4mz 3i2 mte wv 1u 6b2 7ju j57 1r8 2cy 21t 8w9 u8 9n6 3h8 5uq 4nf m7 ma 9id 1ml oi 5ph 2bz 1pf 3zx or 33i 1 5vx yv 5e a5i 48v no 4y8 6e8 2y0 xz m2r 15w 9oh 1jt 1j6 77x 119 5w0 qo 2l ad8 1lw 2b3 of 1x5 ev6 2hl 7g9 598 ij es 9 2sc 2 agn 1r6 6t6 e 2pa 51y aux b0y 1v3 2zr 7oc d6 7wx 6i6 4oe fak 2e8 115 4v 3qy 3 1 2h6 1rq 10o ch8 70i 160 2bz 6pq jb 1qy 1fm cdm 1t7 8u9 1f 34e 2b4 j7 s1 2y5 5bj 4jv ob 4b1 5g9 3q9 d61 77y 2qs up7 c i2a 7d4 4sy ftn 5b8 23v 63h 9w3 how 3ot 6e5 962 5cb 5k8 6eu 5fa 3n8 nf0 6t 2tf 3oz l9d 1m3 j9b 6cx ag4 5m9 9n 59j 1wo 18q 33d bhk yx 7sg 8c7 ty 1t 84d h0 5vx 4oy d77 2cm 4ca 2tb ctm 6ar 4wc fk2 8f8 1h0 3t 7ry bn 10j 8aj 7x 6r3 jo7 b9 26m 18g 4l8 4me 8vf 3uy um 3zq 1hw 10c cw el 42f 5fe 1bq 2hr 1br 483 hu jh 2vm 1h7 96w t3 5uz 53l 18 h6 9th aam 22w xg 1yi 1 3hw 7m6 fv 10d po 6i5 ayk h7 6t3 2cp 3xy hu1 dl0 m9 3ml eo
nein
an
* Ger\xE4te
homebot ist nicht erreichbar
hinzuf\xFCgen
alle
trocken
Ventilator
# ist weg
Gas
aus
Rot
nass
ja
schlie\xDFt
Garagentor
Tor oder Fenster
getrennt
nicht eingesteckt
Toilette
Temperatur
Blau
Noch ist kein Ger\xE4t bekannt. Sie erscheinen hier, sobald sie gefunden werden.
nicht angemeldet
starten
frei
\xF6ffnet
Flur
Hitze
\xF6ffnen
zu Hause
Rechte
# ist zu Hause
Geschirrsp\xFCler
wird unscharf
nicht erreichbar
teilweise scharf
* verborgene zeigen
R\xE4ume
Wohnzimmer
Name
ausf\xFChren
K\xFChltemperatur
Richtung
einschalten
Ger\xE4t
Code f\xFCr $
Lamellen
entriegelt
in Bewegung
belegt
Trotzdem schalten?
Text
Neigung
zur Station
Kohlenmonoxid
T\xFCren, Sensoren und anderes
schlie\xDFen
Lichter in ~
Lichteffekt
Wiedergabe
Graph
ich habe es gesehen
wird scharf
alles zu
r\xFCckg\xE4ngig gemacht
heizt
entriegelt gerade
entriegeln
keine Hitze
zum Inhalt
Markise
Code
k\xFChl
dr\xFCcken
K\xFChlen
nur zum Ansehen
Sauger
Heizen und K\xFChlen
ein
Vorhang
kein Frost
nur L\xFCften
kein Ger\xE4usch
Feuchte
Fehler
keine Sabotage
Decke
Symbol
inaktiv
vorw\xE4rts
verriegelt
ausgel\xF6st
Raum
sp\xE4ter
M\xE4her
Fenster
l\xE4dt
offen
stumm
Zuletzt
durch einen neueren Befehl ersetzt
geschlossen
m\xE4ht
Ohne Raum
Rauch
kein Problem
Ansichten
zuletzt bekannt
* Lichter
l\xE4dt nicht
entfernt
Sicherheit
verbinde \u2026
Dieser Code gilt nicht mehr: homebot gibt beim Start einen neuen aus.
keine Ersch\xFCtterung
spielt
keine Antwort in >
Gr\xFCn
abspielen
< offen
Heizen
Diese Ansicht gibt es nicht.
Ersch\xFCtterung
scharf, abwesend
lauter
Kinder
Schreibtisch
erledigt
T\xFCr
Batterie schwach
Orange
Mehr
l\xF6schen
kein Strom
Kontakt
Licht
Ton an
nicht freigegeben
abgelehnt
Suche
unbekannt
Schlafzimmer
an/aus
drau\xDFen
schwenkt
B\xFCro
aus
Ort
nicht jetzt
Kaffee
Solltemperatur
K\xFChlschrank
aus
Rollo
Halten: $
# aufgesperrt
K\xFCche
Rosa
Kein Ger\xE4t hat diese W\xF6rter in Name, Art oder Raum.
Plan
Steckdose
Pumpe
Taste
Sollfeuchte
Raten
Jalousie
Tastendruck
alle zu Hause
\xDCberblick
Messwert
Batterie
Batterie <
Helligkeit
jetzt <
Anwesenheit
Effekt
an der Station
Zuhause
Diesem Bildschirm fehlt das Recht {right}. Wem das Zuhause geh\xF6rt, der gibt ihm ein Token mit mehr Rechten: System, Einrichten, Bildschirme.
Journal
best\xE4tigt nach >
anhalten
veraltet
starten
Zustand
ruhig
Tasten, Einstellungen und Updates: *
Lichtband
Person
Soll <
stumm
Auswahl
angehalten
bearbeiten
Rollladen
anhalten
nicht zu Hause
verbunden
Farbe
Batterie gut
1 Licht
l\xE4dt
In einem Raum ~ ist kein Ger\xE4t.
reinigt
k\xFChlt
Szene
Zahl
alle an
Waschmaschine
Lichter
scharf, zu Hause
widersprochen: {saw}
* Ziffern
das Ger\xE4t wurde entfernt
Frage
Sirene
# offen
Spannung
Lampe
Bewegung
ausschalten
jemand ist fort
Ger\xE4te werden geladen \u2026
Ger\xE4usch
neutral
warm
unscharf
Noch ist kein Ger\xE4t da: richte dein Zuhause ein.
aktuell
Taster
Kamera
Einrichten
# r\xFCckg\xE4ngig machen
Aktualisierung verf\xFCgbar
r\xFCckw\xE4rts
Wei\xDF
Bad
Lautst\xE4rke
Einrichtung
Frost
Stehlampe
verriegelt gerade
Tageslicht
verriegeln
Sabotage
Lampe
weniger
Schloss
scharf, nachts
schwenkt nicht
leiser
unsicher
pausiert
# endg\xFCltig entfernen
aktuell
kein Gas
abgelehnt ({policy}): &
Keller
Thermostat
Regen
Raum
mehr von #
scharf, im Urlaub
Gelb
Niemand wird erneut benachrichtigt.
* an
eingesteckt
Violett
klemmt
Feinstaub PM2,5
{state} seit >
alle aus
K\xFChlen auf <
entfernen
Anfragen
abbrechen
Kerze
Strom
Problem
kein Rauch
unscharf schalten
Energie
Routinen
neue Szene
kein Licht
Lautsprecher
zu Hause
homebot ist seit > nicht erreichbar: vielleicht startet es neu.
Noch einmal dr\xFCcken: $
Entfeuchten
Tor
Strom
ist von vorher: Das Ger\xE4t hat sich seit dem Start von homebot nicht gemeldet.
nach > zur\xFCckgesprungen
kein Kohlenmonoxid
R\xE4ume
Plan
anhalten
Alarm
System
Esszimmer
Klima
Favoriten
Szenen
Position
kein Regen
* Ger\xE4t
Garage
Garten
Wert
Ventil
Energie
nicht erreichbar
mehr
kehrt zur\xFCck
Belegung
Helligkeit
wartet
Sicherheit
Leistung
erreichbar
es war schon so
automatisch
sicher
Scan
Schalter
Fleck`;export{n as texts};
