var e=`24e 5rm 1ts 2b7 5w 1j0 y4 rn 1pz 40 2gq 5up d1 1c9 25s 105 nh 10b w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 93w 56y 5g 1sr 1 62v 1ir 1gj av 5qs nf 23f 4mf hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 ot 1pj 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 8q 1qy 43 1z3 17l 6k kt 9zn 53l x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 2se 16a 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 2pb 3tv 18j sp 9b 1l2 q0 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv 4z0 14d 72h 1lo py 29q 2os 38b 18q 1e6 4be 66n 9jc 53k e0 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 4l 17l 9nf 38l sw 4ab 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 36 2es 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 3d1 5bi fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 159 1t0 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 3i8 ir bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu 8zc 7z5 ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 1o2 yq 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 2nz zf g2 sl 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1ls 9o 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 60 19n 6z ow 1y4 1kw 89 1qr el rb 1vc n5 39k k2 1s5 1xu 5y3 1hy 4l2 bp1 pi lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 5e8 2mt 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o 3uo 6f2 jx 4dl 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 1mc 179 4d k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 7 230 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 5j 1ih 1s5 w0 1ax cx 1nh ih 2hh 18m 6h sj 17y al q7 3x1 1fo 2wz 1df 6qm 5c1 k9 1dh 6l a1n h ca 13y 10c 4rg 35s 25z rh z0 123 ru 2aw 2kn 3j5 6n 29h 1d6 3p8 1yg 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
Pflanze
der Code ist falsch
es tr\xE4gt das Kennzeichen always_ask
in Betrieb, aber seine Attribute sind nicht lesbar
der Text
Fehler des Journals
Garage
es nimmt keine Befehle, es meldet nur
Farbton (0 bis 360) und S\xE4ttigung (0 bis 100), wie 0,100 f\xFCr Rot oder 240,50 f\xFCr Hellblau
Garten
verlorene Zust\xE4nde
neu beginnen
# ist heruntergeladen ({size} kB).
Es hat noch keine \xC4nderung gemeldet.
Durchflusssensor
einen anderen Schl\xFCssel
nur eine App oder Routine kann eines haben, durch \`act\`
das Ger\xE4t sendet nur
anmelden
Luftqualit\xE4t
abgelehnte Ank\xFCndigungen
sp\xE4te Antworten
wie das System
Hersteller
l\xE4uft homebot schon, frage es: homebot doctor
behalten
Datei mit Daten
Hinzuf\xFCgen
nimmt mehr als 0 und bis 100 %
Terrasse
Meldungen
Protokoll
Feinstaub PM1
getrennte Clients
Kohlendioxid
Gilt ab jetzt.
Warum
An einer Wand
Keiner der neuesten * Eintr\xE4ge hat diese W\xF6rter.
Schwenken
In der Probewoche hast du das {done} von {total} Malen getan; eine Routine h\xE4tte in {low} bis {high} % der F\xE4lle recht.
es hat seit dem Start von homebot noch nichts gemeldet
R\xFCckfrage
Interpret
homebot show DEVICE zeigt beide Seiten; homebot forget DEVICE beendet es
er hat keinen Bewegungsmelder
T\xE4tigkeit
lang
hei\xDF ab
Noch gibt es weder Schloss noch Kontakt noch Alarm.
niedrig
jetzt
der Matter-Server hat kein Bluetooth; er erreicht nur Ger\xE4te im Netz
lief
Rohdaten
Tag
sein Gateway kodiert seine Nachrichten
ohne Token weiter
{issuer} wollte {values}
Fernseher
Feinstaub PM10
du hast es > vorher getan
wird gesendet \u2026
Verlauf
die Kopplungen mit Apple Home
ein unbekanntes Programm
der Matter-Server wurde beendet
das Recht geben
keine Szene bewahrt einen auf
das Ger\xE4t antwortet mit einem Fehler
ein Matter-Code hat 11 oder 21 Ziffern oder ist ein QR-Code, der mit MT: beginnt
tu
der Raum des Ger\xE4ts
es wurde abgebrochen
Was bekannt ist, und woher
Gefrierschrank
sein Modus ist unbekannt; stelle ihn zuerst ein
Port
abgelehnte Typen
zu lang
au\xDFerhalb aller R\xE4ume
verworfen, weil zu langsam gelesen
ist nass
sein anderer Sollwert ist unbekannt, und beide geh\xF6ren zusammen
unbekannte Antworten
Kontaktsensor
abgelehnte Ank\xFCndigungen
Alarme
Aktualisierung
kein D-Bus; unter Linux m\xFCssen bluetoothd und der Systembus laufen
Sie wird erstellt \u2026
Es hat sich um > ge\xE4ndert.
durch {issuer}
Ein schwaches Licht f\xFCr den Weg in der Nacht.
Favorit
Batterie, Strom, Reichweite?
Nicht verstanden um >:
Bewegung
Diagnose
es l\xE4sst sich nicht als UTF-8 kodieren
Anwesenheit
die letzten 24 Stunden
Ein Server auf diesem Rechner
Titel
kein TCP-Port ist frei f\xFCr den eigenen Broker
seine Vorlage scheitert an diesem Code
Verbindung
Ein L\xFCfter l\xE4uft, solange das Bad feucht ist.
verlorene R\xFCckmeldungen
n\xF6tig sind Sekunden, 0 oder mehr
noch kein Verlauf, oder nicht nutzbar; \`homebot doctor\` sagt, warum
homebot neu starten
Es gibt kein Ger\xE4t # (mehr).
von Hand oder von selbst
homebot why GER\xC4T zeigt die Meldungen
homebot l\xE4uft zur Probe und sendet nichts
die Wirkung h\xE4lt nicht an
Medien
seine Vorlage ergibt daf\xFCr nichts
Benutzer
es hat sich seitdem ver\xE4ndert; sieh es noch einmal an
gesendet in einer Nachricht an die Gruppe #
die Verbindung zu Home Assistant ging verloren
endet
Befehle
Z\xE4hler
verworfene Mitteilungen
r\xFCckg\xE4ngig
meldet Kohlenmonoxid
kein Weg f\xFChrt Befehle dorthin
es macht das Haus sicherer
meldete {values}
es ist zu lange stumm
Freigabe
Ist das Geh\xE4use offen, oder ist es von der Wand?
wartend
nach einem falschen Code braucht es eine Pause; versuche es sp\xE4ter
Plan mit * Raum
dort antwortet kein Programm: starte es, oder berichtige die Adresse
Rauch- oder CO-Melder
Frostmelder
es ist keine Hue Bridge; verbinde die Bridge, zu der es geh\xF6rt
es hat sich seit deiner Freigabe ver\xE4ndert
$ im Lauf der Zeit, * Punkte
Noch ist nichts geschehen.
dieses Protokoll nimmt keine rohen Befehle; nimm eine Textadresse
Licht, solange sich jemand bewegt und es dunkel ist; eine Lampe, die schon an ist oder die jemand inzwischen schaltet, bleibt wie sie ist.
Wer sie jetzt braucht
nicht verf\xFCgbar
Ein Token gibt dieser Seite ihre Rechte: Deines ist die Zeile in owner.token, im Datenordner von homebot. F\xFCr ein Tablet erzeugst du eines mit:
K\xFChler, wenn niemand zu Hause ist, wieder warm mit dem Ersten, der kommt.
, durch einen Menschen
Wie ntfy://TOPIC oder mailto://USER:PASSWORD@HOST; appriseit.com nennt alle.
die Verbindung wurde beendet
nimmt einen Zeitpunkt von 1970 bis 2106
nichts tun
nimm ein Verzeichnis auf diesem Computer, oder trage seine Adresse ein
die Tabelle eines Gateways hat Geheimnisse, keine Seite liest sie
Einstellung
das neuere homebot wieder installieren oder: homebot restore BACKUP
Eine Nachricht, wenn die Garage offen bleibt, und immer wieder.
die Ursache im Protokoll beheben, dann: homebot app reload APP, oder homebot neu starten
es hat gerade andere Themen angek\xFCndigt, vielleicht eines anderen Ger\xE4ts
Klimaanlage
verworfene Teile
Neue Gateways beginnen mit dem n\xE4chsten Start von homebot.
sie wartet h\xF6chstens eine Minute auf Ger\xE4te von vorher; versuche es noch einmal
seine Bridge erreicht es nicht
Feuchtesensor
Alarme und Fragen gehen \xFCber diese Adressen an Handys, Chats und E-Mail.
die Steuerung l\xE4uft nicht; sie startet von selbst neu, siehe System
gescheiterte Befehle
\u2026 und * weitere
es kommen keine Ereignisse mehr
mit diesem Code wurde kein Ger\xE4t gefunden; ist es bereit zum Verbinden, in diesem Netz und noch nirgends verbunden?
Gekoppelt mit * Steuerger\xE4ten.
erlaubt
nimmt Zahlen von 0 bis 360, 0 bis 100
# verwenden
Wartet auf deine Freigabe
Sabotage
Personen
das widerspricht sich; gib nur eines an
Fenster auf, hinausgehen, Hilfe rufen
fr\xFCher
, weil die Szene {scene} angewandt wurde
gespeichert
, weil die Szene {scene} r\xFCckg\xE4ngig gemacht wurde
seit >
nimmt nur true
der Name des Rechners ist unbekannt: berichtige die Adresse
Breite
im Haus verbergen
beobachtet: #
Zeilen erscheinen hier, sobald sie kommen.
beginnt mit {view}
Wohnzimmer
den Absender richten oder entfernen
nimmt einen Zeitpunkt mit Zeitzone
N\xF6tig ist: $
Tags nehmen keine Befehle
Hier erscheinen die Ger\xE4te dazu.
Noch meldet kein Ger\xE4t eine Temperatur.
Der Sauger reinigt einmal am Tag, wenn alle gegangen sind.
Regensensor
Eine Heizung ruht, solange ihr Fenster offen ist.
\`homebot find\` zeigt, was passt
nenne password_file oder password_env in [gateways.mdns.drivers.shelly]
nimmt keine
neueste Version
Modell
if: was dann alles gelten muss
verlorene Nachrichten
innen
Schlafenszeit
Werte
nicht aufbewahrte Nachrichten
der Client #
fehlende Bibliothek
es dauerte zu lange
Bodenfeuchte
jeder Schritt
Dieses Bild ist nicht mehr neu.
Ank\xFCndigungen: Bytes im Speicher
wann
nach
Quarant\xE4nen
wechseln oder laden
ein neuer Raum
abgelehnte Anfragen
Eine aufbewahrte Nachricht sagt es, aber nicht seit wann.
Taster
Drehzahl
Alarmanlage
Saugroboter, die noch keine Roboter sind
Noch ist kein Ger\xE4t da.
Warmwasserbereiter
QR-Code
Stichw\xF6rter
es ist nicht erreichbar
feucht ab
dunkel unter
Tage
Bild von #
Nutzer
{energy} eingespeist
\xE4ndern
homebot l\xE4uft ohne Datei; starte es in einem Ordner mit homebot.toml
Jedes Ger\xE4t hat einen Raum.
Uhrzeit
Schlafzimmer
Jetzt
zuletzt geh\xF6rt
Grenze
der Broker antwortet nicht mehr
verbinden
es braucht einen Code
Sicherung
die Tabelle erg\xE4nzen und homebot neu starten: docs/robots.md
das Ger\xE4t hat diesen Teil nicht mehr
Dr\xFCcke den Knopf am Ger\xE4t, dann \u201Everbinden\u201C.
die Verbindung ging verloren
Rasenm\xE4her
neueste zuerst
Was diese Szene verwahrt, sagt ihre Werte nicht.
verpasste Neuigkeiten
Kein Ger\xE4t dieses Hauses passt: $
es lehnt das Passwort aus password_file oder password_env in [gateways.mdns.drivers.shelly] ab
weiter
gefunden und noch nicht benutzt
es ist besch\xE4ftigt
Zeiten und das Haus
Graph
nichts davon ist bekannt, was eine Szene zur\xFCckholen k\xF6nnte
Dieser Bildschirm
Keller
es ist schon anderswo verbunden; entferne es dort oder setze es zur\xFCck
eine Bridge hat keinen Code: dr\xFCcke ihren Knopf
Er darf
verworfen f\xFCr Abwesende
zur\xFCckgewiesen
die Adresse eines Streams, etwa eines Radios
Zu zwei Dritteln herunter, solange es hei\xDF ist.
{least} bis {most}
Eine Nachricht, wenn ein Fenster offen bleibt, w\xE4hrend es drau\xDFen kalt ist.
Eine Nachricht, wenn eine Weile viel Strom verbraucht wird.
in Ruhe
eine Szene hat Werte, die bleiben; f\xFCr Einmaliges nimm eine Routine
Plan wird geladen \u2026
schlie\xDFen
Betriebsart
T\xFCren und Fenster
erreicht \xFCber
es steht in der Konfiguration; \xE4ndere dort [places]
, wegen $
Mehr Bedienung
es leitet zu oft um
Name, Raum und Stichw\xF6rter
es hat nicht rechtzeitig geantwortet
Bild
Zeitzone
homebot wird befragt \u2026
Gateway
Luftbefeuchter
Ein Druck am Bett: alle Lichter aus, und eine Nachricht, wenn etwas offen ist.
Noch gibt es keine Routine.
Handy im Netz
H\xE4ufigkeit
Keine Flamme, kein Schalter; Fenster auf, hinausgehen, Hilfe rufen
Es gibt nichts vorzuschlagen.
keine Antwort
abgelehnte Adressen
Die meisten Nachrichten
ein anderes Passwort
Name
andere
Nachts k\xFChler.
Eine Nachricht, wenn eine Pflanze Wasser braucht.
nenne ein Ger\xE4t, oder suche wie 'light in hall'
vorgeschlagen von #
Tag-Leser
als N\xE4chstes
r\xFCckg\xE4ngig machen
meldet einen Eingriff
L\xE4nge
Name und Ort
Sirenenton
Energie am {day}
Eine Steckdose geht nachts aus, wenn ihr Ger\xE4t nur wartet.
Home Assistant lehnt es ab, oder der Code ist falsch
abgelehnte Verbindungen
Fertige Routinen
{issuer} sandte {text}
Abend
Kohlenmonoxid
ohne Angabe von Gr\xFCnden
Licht im Flur, wenn die Haust\xFCr im Dunkeln aufgeht.
Bodensensor
Noch meldet kein Ger\xE4t Leistung oder Energie.
hat eine schwache Batterie
verworfen, da zu lang
falls
verworfen, da entstellt
Morgens und abends warm.
Farbtemperatur
Jeder Bildschirm hat ein eigenes Token, das man ihm nehmen kann.
wartende und verlorene Nachrichten
es leitet zu einem anderen Rechner um, dem wird nicht gefolgt
verworfene Anfragen
das Verzeichnis ist noch nicht gelesen
eine endliche Zahl
Energie je Tag
hat ausgel\xF6st
Erdgeschoss
Ruhezeit
zu deinem machen oder in HOMEBOT_DATA einen anderen nennen
when: was sie startet, je eine Zeile
darf schalten
Zeige
Der Code auf dem Ger\xE4t
Fehler der Ger\xE4teliste
Ank\xFCndigungen: Bytes zu viel
Ein Taster schaltet eine Lampe.
speichern
nimmt true oder false
Werte
gesendet
aufgeschobene Ank\xFCndigungen
kalt unter
Deine Gewohnheiten
meldet Gas
zeigen
Passwort
setzen
dieses Ger\xE4t gibt es nicht
es hat keines
Die ersten Werte kommen in zwei Sekunden.
Wasser
seine Beschreibung nennt den Parameter nicht
Brennt es? Verlasst das Haus und ruft die Feuerwehr
die Frage gibt es nicht mehr; \`homebot answer\` nennt die offenen
abgeleitete Ank\xFCndigungen
Ein Klingeln wird gemeldet und macht im Dunkeln Licht am Eingang.
letzte L\xE4ufe
Befehle
Temperatursensor
der Raum des Ger\xE4ts ist unbekannt, also ist vielleicht jemand dort
Ein Ger\xE4t ohne Wert geh\xF6rt nicht mehr dazu.
Das Haus ist zu
Raumtemperatur
in Betrieb
Roboter
Token erzeugen
am meisten #
nicht bekannt: {names}
harmlos
Wasser abstellen
das Protokoll hat jeden mit seiner Spur: melden oder beheben
kein Weg zu diesem Rechner
es ist kein Bluetooth-Proxy; erg\xE4nze "bluetooth_proxy:" in seiner ESPHome-Konfiguration
Bad
neu angelegt
der Broker
nur ein Mensch antwortet, auf der Seite
Eine Nachricht, wenn ein Gefrierschrank eine Weile zu warm ist.
nichts wurde damit vereint
Verborgen
ist offen
Das steht jetzt in homebot.toml:
es hat keinen Auftrag; nenne ihm ein Ziel
Ereignisschleife
Melder
Flur
# freigeben
zu viele falsche Codes; nimm es kurz vom Strom
die T\xFCr ist vielleicht offen
Verriegelung
Ohne eigenen Z\xE4hler
Alles ist in Ordnung. Zu beachten:
Nachrichten
True oder False
Noch hat kein Raum eine Form. Gib ihm Ecken in der Tabelle [places.rooms], oder lies eine Karte ein: homebot places import DATEI.
beginnt
meldet Rauch oder Hitze
Widerspruch
verbergen
hoch
es wurde erst nach der Freigabe angek\xFCndigt
du hast es nicht getan
es hat keines angek\xFCndigt
jetzt ausf\xFChren
Der Code, den homebot run ausgibt, l\xE4sst den ersten Bildschirm ein.
eingespeiste Energie
gescheiterte Anmeldungen
niemand hat es erfahren; [notify] und das Log sagen, warum
nur die Tabelle eines Gateways nimmt Passwort oder Token
Bildschirme
der Roboter hat einen Auftrag; setze seine Option zuerst auf idle
abgelehnte Werte
Es war so bei der ersten Meldung.
Die Testnachricht ist verschickt.
wo dieser Bildschirm ist
immer fragen
\xFCbergangene Ank\xFCndigungen
, unterwegs
Werte, Verlauf, Fakten
Sie beh\xE4lt die jetzigen Werte von:
Sie enth\xE4lt alles, was homebot aufbewahrt, aber keine Passw\xF6rter.
in diesem Modus gibt es diesen Sollwert nicht
Ein voller Punkt ist an, offen oder belegt.
Zum Zur\xFCckspielen:
dieses homebot bewahrt nichts auf
homebot show GER\xC4T
Ordner f\xFCr Daten
dazu geh\xF6ren zwei verschiedene Ger\xE4te
Sieben Tage
Ortung
von Hand
Home Assistant hat die Verbindung beendet
der Code ist falsch; wenn du dir sicher bist, versuche es noch einmal
gek\xFCrzte Kennungen
das Gateway beobachtet nur; erlaube ihm Befehle unter System, Ger\xE4te
Das Haus ist offen
nicht hier
Seit der letzten Freigabe ge\xE4ndert:
fertige Routinen
meldet ein Problem
noch keine g\xFCltige Ank\xFCndigung; starte es oder seine Bridge neu, oder warte
es gibt nichts zur\xFCckzunehmen, oder die Datei wurde seitdem ge\xE4ndert
suche \u2026
Sein letztes Ereignis, das kein Zustand ist:
ein Passwort allein ginge unverschl\xFCsselt an jeden, der sich so nennt: erg\xE4nze "api: encryption:" in seiner ESPHome-Konfiguration und nenne key_file, oder seine feste IP-Adresse als allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
es geschieht einmal und h\xE4lt nicht an
zum Haus
waagrechtes Schwenken
\xD6ffne das einmal auf dem Bildschirm; es wird nur jetzt gezeigt:
Der Ort ergibt Sonnenaufgang und Sonnenuntergang; er bleibt hier.
der Roboter hat seinen Zustand noch nicht gemeldet
Voreinstellung
sein Speicher ist voll
keiner Adresse
es schaltet den Alarm unscharf
Sensor
die jetzigen Werte nehmen
Eine Lampe leuchtet von der D\xE4mmerung bis zur Schlafenszeit, wenn jemand zu Hause ist.
vorbehaltene Topics
die Bridge antwortet etwas Unbekanntes
abgelehnte Ger\xE4te
# ist verbunden.
Heizung
nicht verbunden
bleibt
Person
verworfen (QoS 0)
Helligkeit
since muss vor until liegen
Keine App l\xE4uft.
nimmt einen Zeitpunkt ohne Zeitzone
Routinen werden geladen \u2026
gib homebot ein beschreibbares Verzeichnis (HOMEBOT_DATA), oder starte es mit --ephemeral
eine Minute warten, dann das Protokoll ansehen
mehrere Namen f\xFCr eine Kennung: vielleicht mehrere Ger\xE4te
es verlangt mehrere zugleich, das geht nicht
Haushalt
Stockwerk
das Ger\xE4t l\xE4sst sich nur ausschalten, wie ein Herd zur Sicherheit
noch nicht verbunden
das Profil des Ger\xE4ts hat daf\xFCr keinen Rahmen
Die Freigabe erlaubt diese Befehle:
das Token gilt nicht mehr, oder f\xFCr etwas anderes
durch ein anderes Programm
zur\xFCck
Geheimnis
Klingel
schreibe \u2026
Knoten links ver\xF6ffentlichen Themen, Knoten rechts abonnieren sie.
, von selbst
verworfene Abl\xE4ufe
Langsamster Empf\xE4nger
der Thermostat ist in einem anderen Modus; \xE4ndere ihn zuerst
, ein Echo
du hast es > sp\xE4ter getan
annehmen
HomeKit hat daf\xFCr keinen Dienst
Gefunden:
nicht erreichbar
Das Zertifikat, dem deine Ger\xE4te vertrauen sollen
berichtigen, dann: homebot config check
Signalst\xE4rke
Nach f\xFCnf Minuten zeigt er eine dunkle Uhr und was offen ist. Die Adresse dieses Bildschirms:
Es ist so, seit homebot davon wei\xDF.
es wurde nicht gesendet
Stromz\xE4hler
au\xDFer Betrieb
Rollladen oder Vorhang
Graph wird geladen \u2026
Token oder Code
T\xFCrschloss
gesendet in einer Nachricht an die Szene #
, durch ein anderes Programm
noch wurde nichts ge\xE4ndert
L\xFCfterstufe
Alles ist in Ordnung.
nimmt eine Zahl, die sein Format kennt
Es heizt bei offenem Fenster
es ist kein JPEG, PNG, GIF oder WebP bis 2 MiB
vor >
verworfen, weil zu gro\xDF
das Ger\xE4t oder seine Ank\xFCndigung berichtigen
Betriebsart
du, durch $
wenn sie startet, w\xE4hrend sie l\xE4uft
Ger\xE4te
Ausgelassen, weil geheim: {files}
Testnachricht senden
Noch ist nichts gez\xE4hlt.
on oder off
homebot kann hier nicht selbst neu starten; starte es neu
kein Weg in dieses Netz
Verz\xF6gerung der Ereignisschleife
das Protokoll und homebot journal sagen mehr
homebot nach einer neuen Tabelle neu starten: docs/protocols.md
neue Routine
Frequenz
Suchen
abgelehnte Befehle
der Matter-Server ist zu langsam
danach
versp\xE4tet um
strittig
# darf Ger\xE4te schalten
gib eines an, wie level 40
Druck
jedes Mal
Wassermelder
Wasserventil
Morgen
empfangen
bluetoothd l\xE4uft nicht
ein Passwort
gib jedem Ger\xE4t in seinen Ank\xFCndigungen eine eigene Kennung; bis dahin hei\xDFen seine Teile so
alle zu Hause
Wasser l\xE4uft aus
lange offen
Aufzug
Bewegungsmelder
abgelehnte Topics
kein Befehl schickt Leute nach Hause
zusehen
verloren
Antworten
Jetzt den Knopf dr\xFCcken: noch * s
CoAP kennt diese Methode nicht
Zuletzt hier
do: ihre Schritte, je eine Zeile
einen Text
Plan mit * R\xE4umen
ohne Raum
gleichzeitig
Batterie l\xE4dt
Licht und eine Nachricht, wenn Wasser ist, wo keines sein soll.
# entfernen
Drucksensor
Sicherung erstellen
es hat keine Adresse
abgelehnte Nachrichten
{nodes} Knoten und {topics} Themen
mehrdeutige Ank\xFCndigungen
fl\xFCchtige Stoffe
Aus dieser Zeit ist nichts gespeichert.
zusehen und schalten
Helligkeitssensor
Rechte
Apps
schwache Batterie
Sicherungsschalter
Sofort eine Nachricht, wenn eine T\xFCr aufgeht und niemand zu Hause ist.
abgelehnte Abonnements
ablehnen
Heute
ge\xE4ndert zu {values}
sendet, was seine Ank\xFCndigung nicht erkl\xE4rt
Token
nenne den Schl\xFCssel, den seine ESPHome-Konfiguration unter "api: encryption:" hat, als key_file, oder keinen
Raum
{issuer} wurde abgewiesen: &
Thema
homebot erkennt an Handys im Netz und an Trackern, wer zu Hause ist.
abwesend
Lampen gehen abends an und aus, wenn niemand zu Hause ist.
Eine Nachricht, wenn die Waschmaschine fertig ist.
seine Konvention ist ausgefallen
abgesenkt
, durch das Ger\xE4t oder einen Menschen
es hat noch nicht gesagt, was es kann; vielleicht schl\xE4ft es: wecke es
in diesem Browser behalten
gescheiterte Mitteilungen
eine andere Verschl\xFCsselung
Batterie, Strom, Reichweite? Ist es f\xFCr immer weg: homebot forget DEVICE
entfeuchtet
Arbeitszimmer
Warteschlangen und Verluste
Nichts Gemessenes l\xE4uft.
Was du hier \xE4nderst, zeigt jeder Bildschirm.
die Lamellen gehen nur auf (100) und zu (0)
verworfen, da zu viele
eine Zahl
dieses homebot hat keine Routinen
dunkel
Ohne TLS installiert ein Browser keine App: tls = true in [door].
Version
gescheiterte Verbindungen
Saugroboter
Farben
Verschl\xFCsselung
unlesbare Werte
ein Druck auf seinen Knopf
kopiert
abmelden
von selbst
noch * s
nichts
es gibt keine Adresse: in [notify] steht keine
falsche Konfiguration
Eine Lampe wird zwanzig Minuten lang heller, bevor du aufstehst.
der Zustand des Hauses
erneut gesendet
zeigen, was die Freigabe von # erlaubt
homebot sucht im Verlauf von vier Wochen, was du immer wieder tust, und beobachtet es eine Woche, bevor es das vorschl\xE4gt.
die Ger\xE4te des Hauses sind noch nicht bekannt
es l\xE4sst sich nicht beobachten
Rauch, Wasser, Bewegung
K\xFCche
Alle Lichter gehen aus, sobald alle gegangen sind.
Adresse
es ist nicht freigegeben
Durchfluss
Rauch oder Hitze
offen seit
, weil {device} {values} meldete
diese Routine {names} schalten lassen
Betriebsart
Sprache
In der D\xE4mmerung herunter, am Morgen herauf.
alles
das Netz hat es angenommen
nach Gewohnheiten suchen
es geh\xF6rt nicht zu dem, was der Zugang steuern darf
{energy} kWh an anderen solchen Tagen
normal
Luftqualit\xE4tssensor
Nachrichten je Sekunde
l\xE4uft
gerade nicht bekannt
Fehler
hell
vergessene St\xF6rer
einer seiner Werte ist unbekannt
ein anderes Ger\xE4t wird gerade verbunden
In der App Home: +, Ger\xE4t hinzuf\xFCgen, und dies scannen oder den Code eingeben.
homebot place GER\xC4T RAUM
Ank\xFCndigungen`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# wurde in {span} s *-mal hin und her geschaltet$
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
^ # kann nicht < werden: &
kein CoAP-Endpunkt l\xE4sst sich \xF6ffnen: &
kein <-Multicast an der Schnittstelle #: &
mDNS geht nicht an #: &
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
