var n=`fbMUyZpzuCwbve3cb9chcon2YzFLpv2nffRtFBS561OQ36t2S9eef2FjmbbriCY2k7luAzl6mtcPDFUOrsk0XIZrZ2tVgyMvTlmZL73zJj0wxAjA9YXIBayWFGJImpY9AcJbuvLqzEJwmBqfgoEjJa7T17MgJbBBuEynOqelVG9VoztuLerutpIyZRKhSstJXbuLjQxDfC8ePvhHwOUAf68yjWpm4uTBR2yzVUm2h2GkSNf94TFOfVHxQnFQVVZX72iy1spbGaq9HJkkFKu0PIQMvz8q8KT6TlNc5B1DDpQYmGgcGcHw4tiWo6koip3tKT9vIUxvhUGRYtZIhMPQ1adUHbftMg0eUxlhoYrktFzXMm9U1HKZuIsVifyXtHaWDSLMOEgXUUl9wYOB1H3emz0jcgcQgADO1s9GfnjEoWvSQZRN2x8jqcAR6Ah954VfgKwHEg9KP7LlnvcrCINZvlrqq857oIO1YkZYsR6eN8bRTPwJfgWCjxHz8BXocF3iiTUxrWC51kXezAvxNOkPI94Hn6gAWrsVaAWlNv8BA1DKhsRWbgMvtEJm8lElWULqmIfATwpU04OREI0F4IoTEfoJVB7EzLawrBEC8do8J4Dv7CB5jI0qfehTwqUzo7mKdB6DSetJjTP8vwZJVQwDzgT7z3tJ4qGQrRdRAyFurHbrFs0KO47nrDyHmZX3TU08aVmilm8tCYRou5GQRyV0wbT1O6B2ENgbhhvbCF6MiAkct8RrPoRzaIpnJXwaXfSDo5xbm9N1JbpKuFeOe4O3kqYx7g3gG7zs0IyEwYqQHiETJsA4AorORcpqStHdtwcjJLfrHeEQKWBA6lFzScU5qpcUVO59CorPpo3BGtzdJDM9Tarftxf3TP8DpVOfdLh9QbeSd984V7323SP746XxMOE4SnIR4RWLsB6wczeFFnNGwgn6BtIZJw7kcqMnGMiOlI4PC9ZFZY9QxkKYLYfVVh3W
Symbol
sp\xE4ter
Decke
Stehlampe
Schreibtisch
Lichtband
Lampe
Geschirrsp\xFCler
Waschmaschine
K\xFChlschrank
Kaffee
Jalousie
Rollladen
Rollo
Vorhang
Markise
T\xFCr
Fenster
Garagentor
Tor
Wohnzimmer
K\xFCche
Flur
Kinder
Bad
Toilette
Schlafzimmer
B\xFCro
Garage
Garten
Keller
Esszimmer
Raum
Plan
Routinen
Journal
System
Graph
Raten
Ansichten
{count} Ger\xE4t
{count} Ger\xE4te
nicht angemeldet
verbinde \u2026
homebot ist nicht erreichbar
homebot ist seit {time} nicht erreichbar: vielleicht startet es neu.
Diese Ansicht gibt es nicht.
nicht jetzt
Frage
ja
nein
weniger
mehr
mehr von {name}
ein
aus
\xF6ffnen
anhalten
schlie\xDFen
verriegeln
entriegeln
dr\xFCcken
Soll {value}
K\xFChlen auf {value}
Raum
Szenen
{name} r\xFCckg\xE4ngig machen
erledigt
r\xFCckg\xE4ngig gemacht
Ger\xE4te werden geladen \u2026
Noch ist kein Ger\xE4t bekannt. Sie erscheinen hier, sobald sie gefunden werden.
Suche
Kein Ger\xE4t hat diese W\xF6rter in Name, Art oder Raum.
{count} verborgene zeigen
In einem Raum {room} ist kein Ger\xE4t.
Ohne Raum
zuletzt bekannt
ist von vorher: Das Ger\xE4t hat sich seit dem Start von homebot nicht gemeldet.
nicht erreichbar
stumm
nicht freigegeben
aktuell
veraltet
Wert
Plan
ich habe es gesehen
Niemand wird erneut benachrichtigt.
bearbeiten
entfernen
{name} endg\xFCltig entfernen
neue Szene
entfernt
Trotzdem schalten?
abgelehnt
es war schon so
best\xE4tigt nach {time}
widersprochen: {saw}
das Ger\xE4t wurde entfernt
keine Antwort in {time}
Rechte
Belegung
Ger\xE4t
Code
abgelehnt ({policy}): {reason}
nach {time} zur\xFCckgesprungen
durch einen neueren Befehl ersetzt
alle
Name
unbekannt
Tor oder Fenster
Lampe
Thermostat
Ventilator
Pumpe
Kamera
Sirene
Steckdose
Schalter
Lautsprecher
Szene
Person
Batterie
an
aus
schwenkt nicht
schwenkt
Ton an
stumm
erreichbar
nicht erreichbar
offen
geschlossen
\xF6ffnet
schlie\xDFt
angehalten
frei
belegt
kein Rauch
Rauch
kein Kohlenmonoxid
Kohlenmonoxid
kein Gas
Gas
trocken
nass
kein Regen
Regen
kein Frost
Frost
keine Hitze
Hitze
keine Sabotage
Sabotage
keine Ersch\xFCtterung
Ersch\xFCtterung
kein Ger\xE4usch
Ger\xE4usch
zu Hause
alle zu Hause
jemand ist fort
ruhig
in Bewegung
inaktiv
kein Problem
Problem
sicher
unsicher
kein Licht
Licht
kein Strom
Strom
nicht eingesteckt
eingesteckt
getrennt
verbunden
verriegelt
entriegelt
verriegelt gerade
entriegelt gerade
klemmt
Batterie gut
Batterie schwach
l\xE4dt nicht
l\xE4dt
aktuell
Aktualisierung verf\xFCgbar
vorw\xE4rts
r\xFCckw\xE4rts
reinigt
an der Station
kehrt zur\xFCck
pausiert
Fehler
Fleck
m\xE4ht
spielt
l\xE4dt
unscharf
scharf, zu Hause
scharf, abwesend
scharf, nachts
scharf, im Urlaub
teilweise scharf
wartet
wird scharf
wird unscharf
ausgel\xF6st
heizt
k\xFChlt
aus
Heizen
K\xFChlen
automatisch
Heizen und K\xFChlen
Entfeuchten
nur L\xFCften
zu Hause
nicht zu Hause
an/aus
Helligkeit
Farbe
Effekt
Bewegung
Ventil
Position
Neigung
Schloss
Richtung
Sauger
M\xE4her
Alarm
Wiedergabe
Lautst\xE4rke
Tastendruck
Taste
Scan
Auswahl
Zahl
Text
Zustand
Ort
Kontakt
Anwesenheit
Sicherheit
Temperatur
Feuchte
Helligkeit
Leistung
Energie
Spannung
Strom
Feinstaub PM2,5
Messwert
Zuhause
Sicherheit
Klima
Energie
Lichter
Mehr
1 Licht
{count} Lichter
{count} an
alle aus
alle an
alles zu
T\xFCren, Sensoren und anderes
Favoriten
R\xE4ume
R\xE4ume
\xDCberblick
Halten: {what}
Noch einmal dr\xFCcken: {what}
ausf\xFChren
unscharf schalten
einschalten
ausschalten
abspielen
anhalten
starten
starten
anhalten
zur Station
Zuletzt
Batterie {value}
Tasten, Einstellungen und Updates: {count}
abbrechen
l\xF6schen
Code f\xFCr {what}
{count} Ziffern
Lichteffekt
Lichter in {room}
lauter
leiser
jetzt {value}
drau\xDFen
Lamellen
zum Inhalt
Wei\xDF
Kerze
warm
neutral
Tageslicht
Rot
Orange
Gelb
Gr\xFCn
Blau
Violett
Rosa
{name} offen
{name} aufgesperrt
{name} ist zu Hause
{name} ist weg
{state} seit {time}
{value} offen
Einrichten
Einrichtung
Noch ist kein Ger\xE4t da: richte dein Zuhause ein.
Dieser Code gilt nicht mehr: homebot gibt beim Start einen neuen aus.
Taster
k\xFChl
Diesem Bildschirm fehlt das Recht {right}. Wem das Zuhause geh\xF6rt, der gibt ihm ein Token mit mehr Rechten: System, Einrichten, Bildschirme.
nur zum Ansehen
Anfragen
hinzuf\xFCgen
Solltemperatur
K\xFChltemperatur
Sollfeuchte`;export{n as texts};
