var n=`29 1 fh 1mf 14y 5lx gd 6tu 71n 41y ss 19r acd 8e6 98l 58m g9 84r 2lt afv 6 2el 77 1q2 v8 2ca 4lj 24l fp 1c 4c3 1qf 28f 18a 6e1 2s9 i4b 5vd 6ab 227 2ej 6u f 6yl u6 5 5qc 9d7 48s lil byg 5ek 79r 6sy 8bf 17i 3lh 5t 7zt 28g 5no 7hp f2v 82u 2gg 1tq 2w2 34s 6m6 34n e8m 811 2nm 7wa 148 1js 997 2rl 9iu au1 3am wv 1fl 4xa eb 9cj z63 65z 1cs 406 12g zm 55h 5t 1hq 2n4 4v 4ie 1ft zp 222 2q 7jr ebv z7 cuh 2ku 3at adl 4jh 6uf 2lg 447 2d0 3e4 t4 lr 47l 2ns xm 9b 1 289 z1 222 12u 8zb 4te 9nk a8k i9x 11o acw 52a d87 1 5cy v6 6gs 2p0 th 9l7 75p 44x 8lb k3 144 9r 4w6 7ms 4li d4c 9er 223 542 2cd 34x il 37d 3qn 1pg mg 9c5 9mo 768 uo f3p 8gw 2cf ax anf 1kw i1d 3ku 346 716 47z 1qc 200 8 4nw 4ly 1c5 37q 3yo 4en 1jm 105 ob 1 71 2gp 5v0 1a1 6o3 1wg 1cj i6 5fo 32k 4n5 2zo 2gk eei 763 14y 4o9 zf 2h7 74i 1jw gxh 7la bmd 4xu 4x9 1ec 4r5 3qt 7cp 6in 52y 58p rw 62z 5pq 84k 2yz 3o0 f4p 5 1 6xk 7sv 1g7 640 k 3pw 142 bmc q78 36n 4o5 14z 8v4 251 6mp 43q 212 192 42a 71t 11n 1cv 4dc wf 3xe g4 dvp 7vd 7s7 23f 2lm 2h3 3xl ls 4sv 1ds 64f tk 2u gk8 33r 9gp l8v 25g 5go gjq 3o6 1gi 7pz 3ac 235 2l9 3gz zm 7o7 97j 4nr 2uz enn 18s 20q 7cx 9vq 637 23a 7r5 2xi 8gw 2pp dri j 344 34i j bxh 9c 6z6 1lg aey gsz 3lr da6 2lp 3i 3nv 1c0 mtg it 14c hx 5ic 41x 2iz 245 7ck 90o
nein
an
r\xFCckg\xE4ngig gemacht
Ort
\xDCberblick
Richtung
Noch ist kein Ger\xE4t da: richte dein Zuhause ein.
alle aus
spielt
Sollfeuchte
Feinstaub PM2,5
Esszimmer
abspielen
belegt
unbekannt
Tasten, Einstellungen und Updates: *
Taster
Wiedergabe
Problem
hinzuf\xFCgen
alle
Lautst\xE4rke
trocken
Ventilator
Gas
wird unscharf
aus
Halten: $
System
Rot
nass
ja
angehalten
Feuchte
anhalten
anhalten
Plan
Geschirrsp\xFCler
Belegung
Rosa
automatisch
Plan
Steckdose
Zuletzt
Pumpe
Taste
Helligkeit
Sabotage
aus
Trotzdem schalten?
nur L\xFCften
es war schon so
Wei\xDF
Keller
bearbeiten
scharf, zu Hause
kein Licht
ist von vorher: Das Ger\xE4t hat sich seit dem Start von homebot nicht gemeldet.
Violett
Auswahl
stumm
Lamellen
Alarm
schwenkt
Energie
klemmt
unsicher
Strom
Batterie
k\xFChlt
ausgel\xF6st
keine Sabotage
Noch ist kein Ger\xE4t bekannt. Sie erscheinen hier, sobald sie gefunden werden.
Ger\xE4te werden geladen \u2026
wartet
Ohne Raum
nach > zur\xFCckgesprungen
Szenen
B\xFCro
Jalousie
schwenkt nicht
stumm
aus
r\xFCckw\xE4rts
das Ger\xE4t wurde entfernt
Zahl
best\xE4tigt nach >
Kohlenmonoxid
{state} seit >
K\xFCche
* verborgene zeigen
Ersch\xFCtterung
Bewegung
anhalten
Fehler
offen
Journal
M\xE4her
Lichter in ~
frei
zu Hause
kein Kohlenmonoxid
mehr von #
Effekt
* an
Diesem Bildschirm fehlt das Recht {right}. Wem das Zuhause geh\xF6rt, der gibt ihm ein Token mit mehr Rechten: System, Einrichten, Bildschirme.
aktuell
Position
widersprochen: {saw}
keine Hitze
Suche
aktuell
kein Gas
l\xE4dt nicht
Ton an
Schreibtisch
Spannung
keine Ersch\xFCtterung
Dieser Code gilt nicht mehr: homebot gibt beim Start einen neuen aus.
Text
erledigt
T\xFCr
entfernen
Neigung
nicht eingesteckt
Lampe
Lautsprecher
kehrt zur\xFCck
einschalten
abgelehnt
\xF6ffnet
# endg\xFCltig entfernen
Gr\xFCn
\xF6ffnen
Wert
Ventil
Symbol
inaktiv
ausschalten
schlie\xDFt
abgelehnt ({policy}): &
Tor oder Fenster
kein Problem
Raten
ich habe es gesehen
Person
heizt
Temperatur
nicht jetzt
homebot ist nicht erreichbar
lauter
Licht
kein Regen
Leistung
1 Licht
* Lichter
Waschmaschine
Stehlampe
# aufgesperrt
Name
schlie\xDFen
scharf, abwesend
Heizen und K\xFChlen
Diese Ansicht gibt es nicht.
scharf, nachts
Frage
* Ger\xE4t
entriegelt
verbunden
jemand ist fort
alle an
Wohnzimmer
nur zum Ansehen
* Ziffern
leiser
Aktualisierung verf\xFCgbar
sicher
Scan
Code
k\xFChl
Code f\xFCr $
Fleck
keine Antwort in >
Lichteffekt
unscharf schalten
kein Strom
kein Ger\xE4usch
abbrechen
eingesteckt
entriegelt gerade
Kerze
unscharf
Anwesenheit
Solltemperatur
entriegeln
Garagentor
m\xE4ht
R\xE4ume
erreichbar
< offen
jetzt <
durch einen neueren Befehl ersetzt
homebot ist seit > nicht erreichbar: vielleicht startet es neu.
Schalter
alle zu Hause
Zuhause
Flur
ein
Hitze
l\xE4dt
zu Hause
* Ger\xE4te
# ist zu Hause
Ger\xE4usch
Thermostat
Graph
nicht erreichbar
Toilette
verbinde \u2026
l\xF6schen
Kontakt
nicht zu Hause
Frost
pausiert
Mehr
Kein Ger\xE4t hat diese W\xF6rter in Name, Art oder Raum.
teilweise scharf
mehr
Schlafzimmer
veraltet
starten
Zustand
ruhig
Lichtband
Niemand wird erneut benachrichtigt.
verriegelt gerade
Rechte
neue Szene
wird scharf
verriegeln
Tageslicht
Raum
Regen
Blau
# offen
Raum
Einrichtung
Einrichten
drau\xDFen
Farbe
Kamera
Sirene
Batterie <
zum Inhalt
kein Frost
Rollladen
in Bewegung
ausf\xFChren
scharf, im Urlaub
K\xFChlen auf <
Ger\xE4t
Garage
Garten
Kinder
zur Station
Soll <
Tor
Markise
Batterie gut
In einem Raum ~ ist kein Ger\xE4t.
warm
K\xFChlen
K\xFChltemperatur
R\xE4ume
verriegelt
Vorhang
Kaffee
dr\xFCcken
Heizen
Orange
Fenster
Sicherheit
Strom
Lampe
weniger
neutral
Schloss
sp\xE4ter
Szene
reinigt
Favoriten
nicht erreichbar
nicht angemeldet
an der Station
entfernt
Tastendruck
Klima
Entfeuchten
# ist weg
K\xFChlschrank
Ansichten
Noch einmal dr\xFCcken: $
alles zu
Anfragen
nicht freigegeben
getrennt
kein Rauch
Rollo
Messwert
Sicherheit
Helligkeit
Energie
Decke
Bad
zuletzt bekannt
vorw\xE4rts
# r\xFCckg\xE4ngig machen
Batterie schwach
an/aus
T\xFCren, Sensoren und anderes
Sauger
l\xE4dt
geschlossen
Lichter
Gelb
Routinen
starten
Rauch`;export{n as texts};
