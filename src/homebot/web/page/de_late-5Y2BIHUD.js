var e=`12j 1nt xg kp 7jj e9 1ca 7b 6gn o4 1jy 16u 187 3l 43 1ys dl 2gl 9k l 16l dy 1tl mb 18g 1 2g jv ht 1ey b2g 2o9 57v 56 77i 19j 2ce eq 2dy f9 2u5 25s 6sh 2u 34u ds 6z 8u 1ck 15z dw fw tk 9a 3z9 dz 2d 2re 1sy 26q 4il 5th 9s 28y f4 fs 2do afh 8f 3i5 cv 61l 2hu 1 yw 2so 21l qk 1pk f8 49v h0 2nv 50y 1ws 50y 2qv sp qi 1p8 16f qf cf sm 8r ds 1m5 fv 6a 4pw 2p6 143 1bj 2ur 1px 3lz cz 18x 1x9 3eg 2dx 7on 1cp 3c 34y 11h 169 eh df da 8ls 1q9 x4 3xe 14o c7w 3ah 5z 5k 32g s0 l7 9fy 1xr 44j 27j ta g3 ep qk 6mh 12p 1og 1xv 15x 49 el 23l 328 5i 100 327 1wm 1xk 1ap 2t4 2v1 5x 2k 4s 2h8 1kc 2g6 2i9 2no r4 6rc 1v6 1q0 i9 32t 1av 42x xs 13 kd 112 3bm 1n4 1e2 b2 p6 1i3 wv 1w6 3qg 175 3jk g7 41r 2g7 3il 1pz 2g1 ro 3wh 1qt 26e oz 3rr 1tg 1c f3 6yx al 4so 17l 41w 6dv 1kc 1nd cu 1rj 7fv 59c 140 1be 3cm dw 4go 1li zh 4yb 68y c2 5d0 31 2er 3sa 43i 1kz 34i 4w8 13r 22m ak9 2ou 1q1 6gs 2nw v4 hm 3in ay dx 54a 8ph 8yp 1n2 226 5j4 3kr 8p c9 1ax 4x xt 2z1 2b9 1lj 7q3 8ma 7vl cel 24 5el xa mf 3wt 3xk 2qm 6vi hx 6bj 6o 4on byf 4ut t9 2h 405 2ht 1x7 1pt 1eb 4zo 6rz 9yz 53o a8 ow 1cc 3gv 3ej 7a 3r 226 ub 9jc 1v 2cw 8b p9 17l 149 13y 59b 2bs 3pw 1sj 5ho 1ho 17t 8mb fn 2jv rf c0p 2s 14d hy 2nz 1gt r4 1qs 31i 2z9 klp 18a 207 tj tg 3q 3g 2bl ji c 2s9 4x6 6xf 11b 14h 2e8 emi 2tj cz yw 1tn aa 34y 4ut 2y0 1y 2tz gr 2ny 60j 3jv 1nb th 1ew 5jo 7z 1pz 6mz 2pe 2mr tx 1ce 7d7 44g 1w8 x 2fx 11r a9 2m1 4ci 133 9l 72c 6i vc 5um nr 2dc 483 pv 3s 7gs e5 308 l6 447 ui 23k 233 1fi ca lq 2ct vi 23l bq 1ds z0 d6 31k 3ca 4i2 k2 4sq 2g3 1vq 3oz 2a8 26q 341 1r9 28q 344 3d0 1lc 28 13 3je oz z7 206 2gi cj x9 8u 4k5 2pp 7t 37h 3kx rh 2nq 84j 1cx 1bw 4sv 3y 4dy ox 1jt 1dk 1d0 1h 46 4ig r7 392 132 3ok 27c 33y 7j 3ql z4 1tg bg 303 11 28r 1tv 3e 976 6e4 40v bmc 1xq zn 5sd 4so 3u 5lg 38 4j1 3tr 13q 350 8xl 15c 1o8 18z 4m3 af jf 3yp 2vr 2q3 sw 176 7y f 2f4 14r 18b 27i 1q7 56i 2k2 38y 5g3 2s9 lu 1xh xr we 4f6 1ox r 179 ed6 18o 1lc 9r 1 2nd bd 59v 3yl 3zn o 13q 23e ij 9xx gb qp bu to 2ub a1g 11h 1b4 1p3 1cl 40g 1f3 7n3 32e zz ha 1sv 3h6 1pm 2gp 1kl 3qy 1f2 3qi 2d3 23v 5ta 5p 31l 2qw 9nh 5n 39d 28q 16x 3fr 58u 1e3 aa 2c 1h 38r y ep 5tz 3it pv q4 tn k3 18d akw 1ki 1kq 5on is 1nx 16s 19d 3f 2hr 3fi 5up 2zs 2m7 82 3pd 20r 3x7 6f 3lr 5j1 w3 171 kp h 1nr 8ry 16b 17q 42u vd 3po 11x z 26y 9x0 5jo l2 24d 4aw bm 6y 4et 125 35n 1ta 71r 1c5 2y 2f b8 27u 113 4rf 4f5 958 2el 1n7 2d4 32f 7wy 73a 1l1 3ly 4dj 8jf 4n fb 1ua 18k xh
es hat nicht rechtzeitig geantwortet
Garage
Garten
meldet einen Eingriff
falsche Konfiguration
Gateway
Wassermelder
Sieben Tage
Hinzuf\xFCgen
der Roboter hat einen Auftrag; setze seine Option zuerst auf idle
homebot l\xE4uft zur Probe und sendet nichts
Protokoll
Feinstaub PM1
die Tabelle eines Gateways hat Geheimnisse, keine Seite liest sie
Befehle
Warum
der Broker antwortet nicht mehr
abmelden
R\xFCckfrage
Fehler der Ger\xE4teliste
letzte L\xE4ufe
wenn sie startet, w\xE4hrend sie l\xE4uft
niedrig
jetzt
lief
Rohdaten
zu deinem machen oder in HOMEBOT_DATA einen anderen nennen
Tag
Brennt es? Verlasst das Haus und ruft die Feuerwehr
meldete {values}
erreicht \xFCber
l\xE4uft homebot schon, frage es: homebot doctor
kein Weg zu diesem Rechner
when: was sie startet, je eine Zeile
Voreinstellung
dort antwortet kein Programm: starte es, oder berichtige die Adresse
r\xFCckg\xE4ngig machen
Bodenfeuchte
zur\xFCck
fr\xFCher
einer seiner Werte ist unbekannt
Regensensor
hat ausgel\xF6st
es verlangt mehrere zugleich, das geht nicht
Heute
seit >
entfeuchtet
normal
Token
der Raum des Ger\xE4ts
Thema
Verz\xF6gerung der Ereignisschleife
Sprache
N\xF6tig ist: $
Meldungen
abgelehnte Ank\xFCndigungen
schwache Batterie
das neuere homebot wieder installieren oder: homebot restore BACKUP
Neue Gateways beginnen mit dem n\xE4chsten Start von homebot.
Saugroboter, die noch keine Roboter sind
es ist besch\xE4ftigt
Sicherung erstellen
# verwenden
{issuer} sandte {text}
eine Bridge hat keinen Code: dr\xFCcke ihren Knopf
wechseln oder laden
der Raum des Ger\xE4ts ist unbekannt, also ist vielleicht jemand dort
Rauch oder Hitze
gib eines an, wie level 40
Eine aufbewahrte Nachricht sagt es, aber nicht seit wann.
Gilt ab jetzt.
Personen
verbergen
hoch
es tr\xE4gt das Kennzeichen always_ask
der Zustand des Hauses
versp\xE4tet um
nimmt einen Zeitpunkt ohne Zeitzone
Es ist so, seit homebot davon wei\xDF.
Frostmelder
das Netz hat es angenommen
L\xE4nge
von selbst
Ein Token gibt dieser Seite ihre Rechte: Deines ist die Zeile in owner.token, im Datenordner von homebot. F\xFCr ein Tablet erzeugst du eines mit:
Haushalt
Plan wird geladen \u2026
Roboter
Ausgelassen, weil geheim: {files}
abgelehnte Ank\xFCndigungen
Wie ntfy://TOPIC oder mailto://USER:PASSWORD@HOST; appriseit.com nennt alle.
, durch ein anderes Programm
nichts wurde damit vereint
Fehler des Journals
durch ein anderes Programm
gescheiterte Verbindungen
Hersteller
verworfen, da zu lang
homebot why GER\xC4T zeigt die Meldungen
Terrasse
nimmt Zahlen von 0 bis 360, 0 bis 100
homebot erkennt an Handys im Netz und an Trackern, wer zu Hause ist.
vor >
Ruhezeit
{least} bis {most}
Sie beh\xE4lt die jetzigen Werte von:
Betriebsart
ist nass
Ank\xFCndigungen
nimmt true oder false
L\xFCfterstufe
als N\xE4chstes
Das Haus ist offen
zeigen, was die Freigabe von # erlaubt
if: was dann alles gelten muss
Klimaanlage
es wurde nicht gesendet
durch {issuer}
Das steht jetzt in homebot.toml:
Name und Ort
Knoten links ver\xF6ffentlichen Themen, Knoten rechts abonnieren sie.
der Name des Rechners ist unbekannt: berichtige die Adresse
gescheiterte Anmeldungen
au\xDFer Betrieb
Erdgeschoss
abgelehnte Topics
Stockwerk
nimm ein Verzeichnis auf diesem Computer, oder trage seine Adresse ein
Verlauf
jedes Mal
Kontaktsensor
abgelehnte Adressen
schlie\xDFen
nimmt einen Zeitpunkt von 1970 bis 2106
es steht in der Konfiguration; \xE4ndere dort [places]
Betriebsart
nicht verbunden
Handy im Netz
Kohlendioxid
im Haus verbergen
Fenster auf, hinausgehen, Hilfe rufen
nimmt nur true
es hat gerade andere Themen angek\xFCndigt, vielleicht eines anderen Ger\xE4ts
Dieser Bildschirm
{nodes} Knoten und {topics} Themen
Adresse
Farbtemperatur
abgelehnte Typen
Ortung
die Lamellen gehen nur auf (100) und zu (0)
$ im Lauf der Zeit, * Punkte
fl\xFCchtige Stoffe
nicht verf\xFCgbar
sein Speicher ist voll
zuletzt geh\xF6rt
in diesem Modus gibt es diesen Sollwert nicht
kopiert
verbinden
Ank\xFCndigungen: Bytes zu viel
es gibt nichts zur\xFCckzunehmen, oder die Datei wurde seitdem ge\xE4ndert
neu angelegt
nichts tun
seine Vorlage ergibt daf\xFCr nichts
er hat keinen Bewegungsmelder
homebot sucht im Verlauf von vier Wochen, was du immer wieder tust, und beobachtet es eine Woche, bevor es das vorschl\xE4gt.
homebot show GER\xC4T
es hat seit dem Start von homebot noch nichts gemeldet
die Kopplungen mit Apple Home
Keine Flamme, kein Schalter; Fenster auf, hinausgehen, Hilfe rufen
neue Routine
Rollladen oder Vorhang
Noch gibt es weder Schloss noch Kontakt noch Alarm.
Plan mit * R\xE4umen
eine Zahl
Zeitzone
Jeder Bildschirm hat ein eigenes Token, das man ihm nehmen kann.
Hier erscheinen die Ger\xE4te dazu.
Quarant\xE4nen
nimmt keine
Druck
Einstellung
l\xE4uft
Dieses Bild ist nicht mehr neu.
Ein Server auf diesem Rechner
Ein Ger\xE4t ohne Wert geh\xF6rt nicht mehr dazu.
sie wartet h\xF6chstens eine Minute auf Ger\xE4te von vorher; versuche es noch einmal
in diesem Browser behalten
es hat keinen Auftrag; nenne ihm ein Ziel
abgelehnte Ger\xE4te
diese Routine {names} schalten lassen
Luftqualit\xE4tssensor
Deine Gewohnheiten
die Verbindung zu Home Assistant ging verloren
Alarme und Fragen gehen \xFCber diese Adressen an Handys, Chats und E-Mail.
es hat keines angek\xFCndigt
das Ger\xE4t antwortet mit einem Fehler
der Roboter hat seinen Zustand noch nicht gemeldet
Nachrichten je Sekunde
die Adresse eines Streams, etwa eines Radios
Taster
Sein letztes Ereignis, das kein Zustand ist:
gescheiterte Befehle
Zuletzt hier
gespeichert
Rauch- oder CO-Melder
Durchflusssensor
Ank\xFCndigungen: Bytes im Speicher
Signalst\xE4rke
weiter
Suchen
homebot kann hier nicht selbst neu starten; starte es neu
Rauch, Wasser, Bewegung
eine endliche Zahl
Modell
keiner Adresse
abgelehnte Werte
Noch ist nichts geschehen.
Antworten
mehrere Namen f\xFCr eine Kennung: vielleicht mehrere Ger\xE4te
{issuer} wollte {values}
Ist das Geh\xE4use offen, oder ist es von der Wand?
die Verbindung wurde beendet
seine Bridge erreicht es nicht
Rasenm\xE4her
Es hat sich um > ge\xE4ndert.
Melder
das Ger\xE4t sendet nur
Nicht verstanden um >:
Sicherungsschalter
Helligkeitssensor
Dr\xFCcke den Knopf am Ger\xE4t, dann \u201Everbinden\u201C.
das Protokoll und homebot journal sagen mehr
gib homebot ein beschreibbares Verzeichnis (HOMEBOT_DATA), oder starte es mit --ephemeral
Feuchtesensor
gesendet in einer Nachricht an die Gruppe #
alles
Drucksensor
Apps
Home Assistant hat die Verbindung beendet
Noch meldet kein Ger\xE4t Leistung oder Energie.
getrennte Clients
noch nicht verbunden
Wasserventil
nach einem falschen Code braucht es eine Pause; versuche es sp\xE4ter
bluetoothd l\xE4uft nicht
nicht bekannt: {names}
niemand hat es erfahren; [notify] und das Log sagen, warum
Aktualisierung
Alles ist in Ordnung.
Nach f\xFCnf Minuten zeigt er eine dunkle Uhr und was offen ist. Die Adresse dieses Bildschirms:
gesendet in einer Nachricht an die Szene #
Warmwasserbereiter
Anwesenheit
# neu starten
ablehnen
r\xFCckg\xE4ngig
Drehzahl
Alarmanlage
Stromz\xE4hler
Was bekannt ist, und woher
einen anderen Schl\xFCssel
Arbeitszimmer
Ohne eigenen Z\xE4hler
kein Befehl schickt Leute nach Hause
nenne password_file oder password_env in [gateways.mdns.drivers.shelly]
Graph
Es gibt nichts vorzuschlagen.
Es gibt kein Ger\xE4t # (mehr).
H\xE4ufigkeit
das Ger\xE4t hat diesen Teil nicht mehr
# ist verbunden.
Es heizt bei offenem Fenster
Seit der letzten Freigabe ge\xE4ndert:
do: ihre Schritte, je eine Zeile
es ist keine Hue Bridge; verbinde die Bridge, zu der es geh\xF6rt
abgelehnte Abonnements
sendet, was seine Ank\xFCndigung nicht erkl\xE4rt
neueste Version
{energy} eingespeist
wo dieser Bildschirm ist
wann
das Gateway beobachtet nur; erlaube ihm Befehle unter System, Ger\xE4te
Ohne TLS installiert ein Browser keine App: tls = true in [door].
homebot l\xE4uft ohne Datei; starte es in einem Ordner mit homebot.toml
Aus dieser Zeit ist nichts gespeichert.
T\xFCrschloss
Token erzeugen
du hast es nicht getan
Routinen werden geladen \u2026
HomeKit hat daf\xFCr keinen Dienst
vorbehaltene Topics
Fortschritt der Aktualisierung
noch wurde nichts ge\xE4ndert
nenne den Schl\xFCssel, den seine ESPHome-Konfiguration unter "api: encryption:" hat, als key_file, oder keinen
Wartet auf deine Freigabe
keine Antwort
Sicherung
Der Code auf dem Ger\xE4t
Zeige
keine Szene bewahrt einen auf
Home Assistant lehnt es ab, oder der Code ist falsch
nenne ein Ger\xE4t, oder suche wie 'light in hall'
tu
Alarme
abgelehnte Anfragen
Fernseher
empfangen
Noch hat kein Raum eine Form. Gib ihm Ecken in der Tabelle [places.rooms], oder lies eine Karte ein: homebot places import DATEI.
gib jedem Ger\xE4t in seinen Ank\xFCndigungen eine eigene Kennung; bis dahin hei\xDFen seine Teile so
der Code ist falsch
suche \u2026
es nimmt keine Befehle, es meldet nur
eine Szene hat Werte, die bleiben; f\xFCr Einmaliges nimm eine Routine
harmlos
kein D-Bus; unter Linux m\xFCssen bluetoothd und der Systembus laufen
jeder Schritt
Widerspruch
unbekannte Antworten
kein Weg f\xFChrt Befehle dorthin
Nutzer
zu viele falsche Codes; nimm es kurz vom Strom
Port
Energie je Tag
Zeiten und das Haus
gefunden und noch nicht benutzt
Keine App l\xE4uft.
erneut gesendet
seine Vorlage scheitert an diesem Code
Graph wird geladen \u2026
verlorene Nachrichten
neu beginnen
es l\xE4sst sich nicht beobachten
ein unbekanntes Programm
Ger\xE4te
Datei mit Daten
am meisten #
Frequenz
\xE4ndern
on oder off
nur ein Mensch antwortet, auf der Seite
in Betrieb, aber seine Attribute sind nicht lesbar
ein anderes Ger\xE4t wird gerade verbunden
mit diesem Code wurde kein Ger\xE4t gefunden; ist es bereit zum Verbinden, in diesem Netz und noch nirgends verbunden?
abgeleitete Ank\xFCndigungen
das widerspricht sich; gib nur eines an
homebot show DEVICE zeigt beide Seiten; homebot forget DEVICE beendet es
Flur
Medien
Wasser abstellen
es ist nicht erreichbar
das Ger\xE4t l\xE4sst sich nur ausschalten, wie ein Herd zur Sicherheit
kein Weg in dieses Netz
ein anderes Passwort
die letzten 24 Stunden
homebot wird befragt \u2026
Noch ist nichts gez\xE4hlt.
es ist zu lange stumm
zu lang
es wurde abgebrochen
Temperatursensor
hat eine schwache Batterie
die Steuerung l\xE4uft nicht; sie startet von selbst neu, siehe System
Batterie, Strom, Reichweite?
zur\xFCckgewiesen
Farben
R\xE4ume reinigen
nimmt einen Zeitpunkt mit Zeitzone
es hat sich seitdem ver\xE4ndert; sieh es noch einmal an
nur eine App oder Routine kann eines haben, durch \`act\`
es kommen keine Ereignisse mehr
Energie am {day}
\xFCbergangene Ank\xFCndigungen
der Thermostat ist in einem anderen Modus; \xE4ndere ihn zuerst
Name
True oder False
nicht erreichbar
seine Konvention ist ausgefallen
nicht hier
Breite
Schwenken
du hast es > sp\xE4ter getan
Sie wird erstellt \u2026
homebot place GER\xC4T RAUM
Diagnose
nach Gewohnheiten suchen
QR-Code
Jetzt
erlaubt
ohne Angabe von Gr\xFCnden
berichtigen, dann: homebot config check
Batterie l\xE4dt
homebot nach einer neuen Tabelle neu starten: docs/protocols.md
zum Haus
T\xFCren und Fenster
Langsamster Empf\xE4nger
Warteschlangen und Verluste
der Matter-Server wurde beendet
Es war so bei der ersten Meldung.
die Frage gibt es nicht mehr; \`homebot answer\` nennt die offenen
beobachtet: #
die Tabelle erg\xE4nzen und homebot neu starten: docs/robots.md
meldet Rauch oder Hitze
, von selbst
Person
behalten
alle zu Hause
Noch meldet kein Ger\xE4t eine Temperatur.
ein Passwort
Stichw\xF6rter
gescheiterte Mitteilungen
Die meisten Nachrichten
Wasser
danach
der Matter-Server ist zu langsam
das Verzeichnis ist noch nicht gelesen
eine Minute warten, dann das Protokoll ansehen
verworfene Abl\xE4ufe
verworfene Mitteilungen
verworfen, da entstellt
Nachrichten
der Roboter wei\xDF nicht, wo er ist; lokalisiere ihn zuerst
eine andere Verschl\xFCsselung
Sensor
ein neuer Raum
der Client #
es hat noch nicht gesagt, was es kann; vielleicht schl\xE4ft es: wecke es
es dauerte zu lange
Sie enth\xE4lt alles, was homebot aufbewahrt, aber keine Passw\xF6rter.
Favorit
in Ruhe
Bild
vergessene St\xF6rer
Sabotage
# darf Ger\xE4te schalten
vorgeschlagen von #
Freigabe
verlorene Zust\xE4nde
Bildschirme
In der Probewoche hast du das {done} von {total} Malen getan; eine Routine h\xE4tte in {low} bis {high} % der F\xE4lle recht.
nimmt mehr als 0 und bis 100 %
lange offen
sein anderer Sollwert ist unbekannt, und beide geh\xF6ren zusammen
, durch das Ger\xE4t oder einen Menschen
Rechte
T\xE4tigkeit
, ein Echo
, durch einen Menschen
es ist kein JPEG, PNG, GIF oder WebP bis 2 MiB
wartende und verlorene Nachrichten
nichts davon ist bekannt, was eine Szene zur\xFCckholen k\xF6nnte
sein Gateway kodiert seine Nachrichten
ge\xE4ndert zu {values}
jetzt ausf\xFChren
Ein voller Punkt ist an, offen oder belegt.
der Broker
es hat sich seit deiner Freigabe ver\xE4ndert
Betriebsart
wartend
setzen
Kohlenmonoxid
gek\xFCrzte Kennungen
Luftbefeuchter
sein Modus ist unbekannt; stelle ihn zuerst ein
Das Haus ist zu
Alles ist in Ordnung. Zu beachten:
ein Passwort allein ginge unverschl\xFCsselt an jeden, der sich so nennt: erg\xE4nze "api: encryption:" in seiner ESPHome-Konfiguration und nenne key_file, oder seine feste IP-Adresse als allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
ein Druck auf seinen Knopf
Saugroboter
ist offen
verlorene R\xFCckmeldungen
dieses homebot bewahrt nichts auf
An einer Wand
gerade nicht bekannt
Verborgen
noch keine g\xFCltige Ank\xFCndigung; starte es oder seine Bridge neu, oder warte
Der Ort ergibt Sonnenaufgang und Sonnenuntergang; er bleibt hier.
\xD6ffne das einmal auf dem Bildschirm; es wird nur jetzt gezeigt:
Die ersten Werte kommen in zwei Sekunden.
ohne Token weiter
der Code ist falsch; wenn du dir sicher bist, versuche es noch einmal
since muss vor until liegen
Geheimnis
es gibt keine Adresse: in [notify] steht keine
Token oder Code
Jedes Ger\xE4t hat einen Raum.
beginnt mit {view}
Fertige Routinen
\`homebot find\` zeigt, was passt
Was du hier \xE4nderst, zeigt jeder Bildschirm.
Der Code, den homebot run ausgibt, l\xE4sst den ersten Bildschirm ein.
Durchfluss
CoAP kennt diese Methode nicht
Er darf
strittig
, weil {device} {values} meldete
meldet Kohlenmonoxid
mehrdeutige Ank\xFCndigungen
fehlende Bibliothek
der Text
aufgeschobene Ank\xFCndigungen
Verbindung
es l\xE4sst sich nicht als UTF-8 kodieren
In der App Home: +, Ger\xE4t hinzuf\xFCgen, und dies scannen oder den Code eingeben.
den Absender richten oder entfernen
dieses Protokoll nimmt keine rohen Befehle; nimm eine Textadresse
fertige Routinen
Fehler
Gekoppelt mit * Steuerger\xE4ten.
Farbton (0 bis 360) und S\xE4ttigung (0 bis 100), wie 0,100 f\xFCr Rot oder 240,50 f\xFCr Hellblau
Nichts Gemessenes l\xE4uft.
wird gesendet \u2026
wie das System
Tags nehmen keine Befehle
verpasste Neuigkeiten
abgelehnte Verbindungen
\u2026 und * weitere
es ist schon anderswo verbunden; entferne es dort oder setze es zur\xFCck
Wasser l\xE4uft aus
Aufzug
, unterwegs
zusehen
verloren
das Recht geben
Name, Raum und Stichw\xF6rter
Benutzer
Werte
das Profil des Ger\xE4ts hat daf\xFCr keinen Rahmen
Keiner der neuesten * Eintr\xE4ge hat diese W\xF6rter.
einen Text
Schlafzimmer
Was diese Szene verwahrt, sagt ihre Werte nicht.
au\xDFerhalb aller R\xE4ume
es wurde erst nach der Freigabe angek\xFCndigt
Raumtemperatur
Noch gibt es keine Routine.
Verriegelung
Bad
sp\xE4te Antworten
immer fragen
verworfene Anfragen
falls
Zeilen erscheinen hier, sobald sie kommen.
Bewegungsmelder
es hat keine Adresse
dieses homebot hat keine Routinen
nach dem Protokoll beheben: homebot app reload APP, homebot gateway restart NAME
es hat keines
hell
von Hand oder von selbst
# ist heruntergeladen ({size} kB).
, weil die Szene {scene} r\xFCckg\xE4ngig gemacht wurde
nicht aufbewahrte Nachrichten
K\xFCche
waagrechtes Schwenken
Es hat noch keine \xC4nderung gemeldet.
Wer sie jetzt braucht
es ist nicht freigegeben
Ereignisschleife
Werte, Verlauf, Fakten
Werte
zusehen und schalten
die Verbindung ging verloren
verworfen, da zu viele
Verschl\xFCsselung
Ordner f\xFCr Daten
es braucht einen Code
nimmt R\xE4ume, hat aber noch keine genannt
eingespeiste Energie
der eigene Broker kann nicht lauschen: alle Ports sind belegt
es schaltet den Alarm unscharf
Heizung
Zum Zur\xFCckspielen:
Sirenenton
noch * s
Titel
Keller
die Ger\xE4te des Hauses sind noch nicht bekannt
, weil die Szene {scene} angewandt wurde
Raum
# entfernen
abwesend
es lehnt das Passwort aus password_file oder password_env in [gateways.mdns.drivers.shelly] ab
Bodensensor
in Betrieb
es macht das Haus sicherer
von Hand
es geh\xF6rt nicht zu dem, was der Zugang steuern darf
die jetzigen Werte nehmen
verworfen, weil zu langsam gelesen
das Ger\xE4t oder seine Ank\xFCndigung berichtigen
n\xF6tig sind Sekunden, 0 oder mehr
neueste zuerst
Gefunden:
Luftqualit\xE4t
ein Matter-Code hat 11 oder 21 Ziffern oder ist ein QR-Code, der mit MT: beginnt
noch kein Verlauf, oder nicht nutzbar; \`homebot doctor\` sagt, warum
Batterie, Strom, Reichweite? Ist es f\xFCr immer weg: homebot forget DEVICE
, wegen $
nur die Tabelle eines Gateways nimmt Passwort oder Token
nimmt eine Zahl, die sein Format kennt
darf schalten
Die Testnachricht ist verschickt.
du hast es > vorher getan
Feinstaub PM10
Das Zertifikat, dem deine Ger\xE4te vertrauen sollen
Tag-Leser
dieses Ger\xE4t gibt es nicht
Noch ist kein Ger\xE4t da.
der Matter-Server hat kein Bluetooth; er erreicht nur Ger\xE4te im Netz
Plan mit * Raum
{issuer} wurde abgewiesen: &
die Bridge antwortet etwas Unbekanntes
Wohnzimmer
{energy} kWh an anderen solchen Tagen
annehmen
Mehr Bedienung
das Protokoll hat jeden mit seiner Spur: melden oder beheben
Passwort
dunkel
# freigeben
verworfen f\xFCr Abwesende
es leitet zu einem anderen Rechner um, dem wird nicht gefolgt
gleichzeitig
anmelden
verworfen (QoS 0)
Befehle
die Wirkung h\xE4lt nicht an
homebot neu starten
meldet Gas
Jetzt den Knopf dr\xFCcken: noch * s
nichts
Interpret
die T\xFCr ist vielleicht offen
es geschieht einmal und h\xE4lt nicht an
es ist kein Bluetooth-Proxy; erg\xE4nze "bluetooth_proxy:" in seiner ESPHome-Konfiguration
ohne Raum
verworfen, weil zu gro\xDF
abgelehnte Befehle
Version
Die Freigabe erlaubt diese Befehle:
du, durch $
abgelehnte Nachrichten
unlesbare Werte
Bild von #
Testnachricht senden
es leitet zu oft um
meldet ein Problem
Kein Ger\xE4t dieses Hauses passt: $
schreibe \u2026
das Token gilt nicht mehr, oder f\xFCr etwas anderes
dazu geh\xF6ren zwei verschiedene Ger\xE4te
speichern
gesendet
zeigen`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# fragt, also antwortet jemand anders: nimm das Token des Besitzers
# muss selbst fragen
die Frage ist vorbei: &
der Matter-Server antwortet mit dem Fehler *
die Bridge f\xFCr HomeKit kann #, Port * nicht \xF6ffnen: &
es ist noch nicht verbunden; $, mit dem Code darauf
es hat keinen Teil #, sondern $
< geht nicht unter {least}, und es hat keinen Schalter
es verlangt <; &
nimmt Prozent; meintest du < %? F\xFCr $ %: #
nimmt einen Text der Form $ (*)
eine Zahl in $
um $? < ist unbekannt; nenne einen Wert, wie #
es hat keinen Raum: $
# wurde in {span} s *-mal hin und her geschaltet
# wurde in {span} s *-mal hin und her geschaltet; mit Token (\`homebot token new\`) darf ein Programm \xF6fter
nicht geschrieben, beim Neustart verloren: &
# geh\xF6rt gerade einem laufenden homebot
# steht in der Konfiguration; \xE4ndere dort [places]
darin sind Ger\xE4te: $; gib ihnen zuerst einen anderen Raum
kein Befehl gab es an #: dort steht <
den Raum von # nannte kein Befehl
es gibt kein Ger\xE4t #, und kein Befehl nannte seinen Raum
es d\xFCrfen * mit {most} Teilen sein; entferne zuerst eine
zu viele Tests: warte * s
gib es frei mit \`homebot approve ^\`, und {advice}
schadet es niemandem, \`homebot tag add ^ #\`, sonst {advice}
den Vorschlag * gibt es nicht mehr; \`homebot suggest\` nennt alle
# ist nicht ungef\xE4hrlich (&), und es hat sich seit deiner Freigabe ver\xE4ndert: $; freigeben mit \`homebot approve ^\`
^ # ist nicht offen
schreibe, was seine ESPHome-Konfiguration unter "api: encryption: key:" hat, in eine Datei, und nenne sie in [gateways.mdns.drivers.esphome.devices."^"] als key_file
schreibe, was seine ESPHome-Konfiguration unter "api: password:" hat, in eine Datei, und nenne sie in [gateways.mdns.drivers.esphome.devices."^"] als password_file
erg\xE4nze "api: encryption:" in seiner ESPHome-Konfiguration, oder entferne den Schl\xFCssel in [gateways.mdns.drivers.esphome.devices."^"]
es k\xFCndigt sich bei < an, doch allow_plaintext_at ist $; &
jemand muss zustimmen: &
ob # an ist, ist unbekannt; sage on oder off
kein Ger\xE4t passt zu #; &
meintest du #?
nahe # l\xE4sst sich nichts steuern; ausgelassen: $
nicht, solange gilt {condition}: < ist unbekannt
nimmt einen Text der Form $
nimmt $ nach ISO 8601
ein Befehl hat 1 bis *
n\xF6tig ist ein Text von h\xF6chstens * Zeichen
es gibt schon *; nimm welche zur\xFCck
kein Import nennt es; &
es gibt schon * Entscheidungen; mache welche r\xFCckg\xE4ngig
es hat keine Ank\xFCndigung #; es hat $
&; \`at_night\` (\`--night\`) erlaubt es
in ~ schl\xE4ft gerade jemand
nichts wurde ge\xE4ndert, denn die alten Werte lassen sich nicht aufbewahren: &
es gibt kein Ger\xE4t oder Bild #
keine Verbindung in * s
es hat keine Eigenschaft #
kein Ger\xE4t ist erreichbar: &
ein anderer Proxy hat seine Adresse #
die Schnittstelle # taugt nicht f\xFCr <-Multicast: &
^ # l\xE4sst sich nicht \xF6ffnen: &
^ # kann nicht < werden: &
kein CoAP-Endpunkt l\xE4sst sich \xF6ffnen: &
kein <-Multicast an der Schnittstelle #: &
mDNS geht nicht an #: &
$ von [#] geh\xF6rt zur jetzigen Adresse; gib es mit der neuen neu an
$ von [#] nennt ein Geheimnis dieses Rechners; das schreibt nur ein Mensch in die Datei
es ist l\xE4nger als * Zeichen
der eigene Broker kann nicht lauschen: Port * ist belegt
es hat # nicht als Thema f\xFCr Befehle angek\xFCndigt
der eigene Broker kann keinen Port \xF6ffnen: &
es verlangt $, eingetragen ist #
es verlangt $, das geht nicht
es verschl\xFCsselt nicht; &
nimmt einen Text von {least} bis {most} Zeichen
nimmt einen Text von h\xF6chstens * Zeichen
nimmt einen Text von h\xF6chstens $
seine Vorlage scheitert: $
seine Vorlage $
es l\xE4sst sich nicht als $ kodieren
Home Assistant hat sich in * s nicht gemeldet
es w\xFCrde bis {least} \xB0C heizen und bis {most} \xB0C k\xFChlen
HAP-Status *
die Bridge von # ist nicht verbunden
Knoten * ist in Betrieb, aber der Gateway hat schon max_nodes
der Matter-Gateway hat kein Ger\xE4t #
das Ger\xE4t antwortet mit dem Status $
das Ger\xE4t antwortet mit dem Fehler $
die Adresse # ist unbekannt: &
der Inhaltstyp # wird nicht verstanden
die Beobachtung von # ist zu Ende
in # lassen sich keine Kopien anlegen: &
nimmt &, und keine \xC4nderung
es bietet nicht: $
es hat kein Skript #; eine Tabelle [[gateways.ble.proxies]] installiert es
der Roboter nimmt im Modus $ keine Auftr\xE4ge
die Tabelle # darf eine Seite nicht \xE4ndern, nur: $
der Schl\xFCssel # l\xE4dt ein Programm oder eine Datei; trage ihn selbst ein
das Recht # darfst du nicht geben; nimm: homebot token new
keine Sicherung hat ein Byte *; beginne bei 0
die \xC4nderung # nennt nichts
die Adresse # steht nicht mehr in der Datei; sieh noch einmal nach
Gateway # startet neu
Gateway # ist weg: &
# hat in * s nicht geantwortet; ob es geschah, ist unbekannt
abgelehnt (<): &
ging nach * s zur\xFCck, <
nicht gesendet: &
widersprochen: &
der Name des Rechners l\xE4sst sich gerade nicht aufl\xF6sen ($)
# hat den Aufzug
< hat die Verbindung beendet
# ist nicht verbunden: &
# ist nicht verbunden
# hat in * s nicht geantwortet
# schl\xE4ft; versuche es wieder, wenn es wach ist
# ist in Home Assistant nicht verf\xFCgbar
Home Assistant hat keine Entit\xE4t mehr f\xFCr #
# hat keinen Treiber; \`homebot doctor\` nennt, was nicht nutzbar ist
dem Zertifikat von # wird nicht vertraut
$: der Server antwortet *, sp\xE4ter geht es vielleicht
der Server antwortet *
es verlangt ein Passwort (Status *)
mit diesem Passwort l\xE4sst es homebot nicht ein (Status *)
nimmt nicht: <
nimmt eine Zahl von {least} bis {most}
es hat diese Einstellung nicht; es nimmt {list}
# hat keine \xC4nderung gemessen
es gibt kein Ger\xE4t #
niemand ist in ~
# hat noch nie jemanden bemerkt; gehe einmal daran vorbei
# meldet sich erst seit * s
&, und der Zugang darf nur $; erg\xE4nze {right} in [{table}] von homebot.toml
&, und der Zugang darf nur $
ein solches Ger\xE4t braucht ein Recht, das es nennt (&)
$, und das geht noch * s vor
<, nach einer alten Meldung: gerade nicht erreichbar
<, nach einer alten Meldung: zuletzt geh\xF6rt vor {age}
<, nach einer aufbewahrten Meldung: es hat sich noch nicht selbst gemeldet
# hei\xDFt jetzt $
# ist abgelehnt und kommt nicht wieder
# l\xE4uft nicht: &
eine Routine oder App # gibt es schon; w\xE4hle einen anderen Namen, oder \xE4ndere jene
# steht in der Konfiguration; \xE4ndere es dort, und dann: $
nichts r\xFCckg\xE4ngig zu machen: # wurde nicht angewendet, oder es ist schon geschehen
von # ist nichts mehr zur\xFCckzuholen
die Szene # gibt es schon
# ist gerade nicht im Haus; lass es, wie es ist, oder weg
es d\xFCrfen * sein; entferne zuerst eines
# wurde inzwischen ge\xE4ndert; sieh es an, und versuche es noch einmal
# gibt es schon; entferne es, oder nenne den Gateway anders
&, darum nur mit seinem Namen: $
es ist nicht verbunden: $
# ist nicht mit homebot verbunden
das letzte Neuladen wurde abgelehnt: &
keine Antwort in * s
zu viele Codes ohne bekannte Wirkung von {issuer}
nicht, solange gilt {condition}, und der Zustand von # ist unbekannt: &
jemand ist in ~: # war vor * s an, seitdem ging keine T\xFCr auf
vielleicht ist jemand in ~: # \xE4nderte sich vor * s, ohne Befehl
# braucht ein Recht, das es nennt (&), und {issuer} hat keines; {advice}
# braucht ein Recht, denn &, und {issuer} hat keines; {advice}
es steht nicht auf der Liste harmloser Ger\xE4te ($)
auf < gehalten von {holder}, bis es freigegeben wird
noch * s auf < gehalten von {holder}
gehalten von {holder}, bis es freigegeben wird: <
noch * s gehalten von {holder}: <
# hat nein gesagt
niemand hat in * s geantwortet: das geht auf der Seite oder mit \`homebot answer\`
es ist >, und Ruhe von {start} bis {end}
der Roboter # ist in ~ oder dorthin unterwegs
jemand ist in ~: $
vor * s war jemand in ~: $
vielleicht ist jemand in ~: $
unbekannt, ob jemand in ~ ist: &
nicht, solange gilt {condition}: $
das Mitglied # lehnt ab: &
{issuer} darf # nicht steuern, nur: $
{issuer} darf # nicht steuern: &
kein Ger\xE4t ist erreichbar: &
# ist nicht erreichbar: &
# ist gerade nicht im Netz
die Verbindung zu # ging verloren
Art: <
Art: <
es nennt sich #
seine Einheit ist #
es heizt bis * \xB0C
neben einem anderen Teil: &
der Name # sagt $
das Modell # sagt $
Gateway # meldet seinen Zustand nicht
Problem von #
aufgegeben von #
Fehler in # seit dem Start
gez\xE4hlt von # in den letzten zehn Minuten
gez\xE4hlt von # seit dem Start
in Quarant\xE4ne bei #, das nur einen Teil ihrer Nachrichten liest
Hinweis zu #
Gateway # ist < und sendet Befehle
Gateway # ist < und beobachtet nur: &
Gateway # ist < und beobachtet nur
abgest\xFCrzt ({error}), startet in > neu; sofort: {text}
Gateway # ist <: &
& Nach dem Neustart von homebot gilt: {keys}
Die Datei ist wie vorher: &
* Ger\xE4te warten auf Freigabe und bekommen vorher keine Befehle: {list}
1 Ger\xE4t wartet auf Freigabe und bekommt vorher keine Befehle: {list}
die letzte Nachricht wurde nicht gesendet: &
zuletzt geh\xF6rt vor {age}
erledigt: $
ausgelassen: nicht $
$ ging nicht: &
< (* %)
<, seit {age}
# ist nicht ungef\xE4hrlich (&), und <; freigeben mit \`homebot approve ^\`
die Regel ist ausgefallen: $
* Befehle warten noch auf ihren Ausgang
sein Gateway # ist <: &
sein Gateway # ist <
# hat in * s nicht geantwortet: $
niemand h\xF6rt auf $
sein Knopf wurde in * s nicht gedr\xFCckt; dr\xFCcke ihn und versuche es noch einmal
# wurde nicht verbunden: &
$ wurde abgelehnt: &
# hat kein Bild
^: # hat von seinem letzten Befehl nichts bemerkt; nach der Reparatur \`homebot trust $\`
nimmt: &
dieser Teil nimmt: {list}
keiner seiner Modi: {list}
das Ger\xE4t antwortet: &
# ist schon mit homebot verbunden
# geh\xF6rt zur Bridge $, die als Ganzes verbunden wird
&; wieder in * s
von hier geht nur: <
den Raum # gibt es schon
# hei\xDFt schon so
# ist anderswo verbunden; trenne es dort oder setze es zur\xFCck, dann $
# ist entfernt
# ist ge\xE4ndert
# ist hinzugef\xFCgt
# hat ja gesagt
# antwortet nicht
# hat nicht geantwortet
# nimmt keine Befehle, die homebot kennt
* Ger\xE4te passen zu #; h\xF6chstens {most} gehen auf einmal
$ wurde nicht an # gesendet: &
$ wurde an # gesendet: &
$ von #: &
# hat schon $
# hat keinen Teil
# ist mit TLS nicht erreichbar: &
* Bluetooth-Proxys sind schon verbunden
# braucht l\xE4nger als * s f\xFCr eine Antwort
# ist an keinem Endpunkt bekannt
# hat keine HTTP-Adresse
# hat keine Adresse
# beantwortet keine Anfragen
# nimmt keine Nachricht
# hat die Ereignisse beendet
# l\xE4sst sich nicht als $ ank\xFCndigen: &
#: * Befehle warten schon auf $
# l\xE4sst sich nicht \xF6ffnen: &
# wurde nicht gesetzt: &
# wird mit dem Code darauf verbunden: $
# ist schon in Betrieb genommen
# geh\xF6rt zur Bridge $ (^); nur die Bridge l\xE4sst sich entfernen
# antwortet dem Matter-Server nicht
# hat sich noch nicht beschrieben
$ von # l\xE4sst sich nicht setzen
# l\xE4sst sich nicht schreiben: &
# l\xE4sst sich nicht beiseitelegen: &
# l\xE4sst sich nicht kopieren: &
# von $ passt in keine eigene Datei
# = $ ist kein Wert von TOML; Texte brauchen Anf\xFChrungszeichen
# geht nicht als Name: nimm bis * druckbare Zeichen
# geht nicht ($): &
es ist >, und von {start} bis {end} wird geschlafen
\`$ --act ^\` gibt eines
$ act = [^] gibt eines
# bei $: &
$ in Schritten von *
$ Sekunden oder mehr
{least} bis {most} s
# (&)
es gibt nicht: < #; &`;export{n as reasons,e as texts};
