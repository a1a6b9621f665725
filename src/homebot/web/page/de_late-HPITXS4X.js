var e=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 2nx w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 21p 727 56y 5g 1sr 1 62v 1ir 1gj 61n nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 1zo 43 1z3 17l 6k kt f38 x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv d5u 1lo py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 32g 3b8 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 2hy 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu gyh ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 3ne 18n 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3j0 89 1qr el rb 1vc n5 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 811 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 2hh 18m 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 k9 1dh a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
Pflanze
der Code ist falsch
es tr\xE4gt das Kennzeichen always_ask
der Text
Fehler des Journals
Garage
Garten
verlorene Zust\xE4nde
neu beginnen
{name} ist heruntergeladen ({size} kB).
Es hat noch keine \xC4nderung gemeldet.
Durchflusssensor
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
Keiner der neuesten {count} Eintr\xE4ge hat diese W\xF6rter.
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
nimmt einen Text
du hast es {time} vorher getan
wird gesendet \u2026
Verlauf
die Kopplungen mit Apple Home
ein unbekanntes Programm
der Matter-Server wurde beendet
das Recht geben
keine Szene bewahrt einen auf
ein Matter-Code hat 11 oder 21 Ziffern oder ist ein QR-Code, der mit MT: beginnt
tu
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
Sie wird erstellt \u2026
Es hat sich um {time} ge\xE4ndert.
durch {issuer}
Ein schwaches Licht f\xFCr den Weg in der Nacht.
Favorit
Batterie, Strom, Reichweite?
Nicht verstanden um {time}:
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
homebot neu starten
Es gibt kein Ger\xE4t {name} (mehr).
von Hand oder von selbst
homebot why GER\xC4T zeigt die Meldungen
homebot l\xE4uft zur Probe und sendet nichts
die Wirkung h\xE4lt nicht an
seine Vorlage ergibt daf\xFCr nichts
Benutzer
es hat sich seitdem ver\xE4ndert; sieh es noch einmal an
gesendet in einer Nachricht an die Gruppe {name}
die Verbindung zu Home Assistant ging verloren
endet
Befehle
Z\xE4hler
verworfene Mitteilungen
r\xFCckg\xE4ngig
meldet Kohlenmonoxid
es macht das Haus sicherer
meldete {values}
es ist zu lange stumm
Freigabe
Ist das Geh\xE4use offen, oder ist es von der Wand?
wartend
nach einem falschen Code braucht es eine Pause; versuche es sp\xE4ter
Plan mit {count} Raum
dort antwortet kein Programm: starte es, oder berichtige die Adresse
Rauch- oder CO-Melder
Frostmelder
es ist keine Hue Bridge; verbinde die Bridge, zu der es geh\xF6rt
es hat sich seit deiner Freigabe ver\xE4ndert
{what} im Lauf der Zeit, {count} Punkte
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
Klimaanlage
verworfene Teile
Neue Gateways beginnen mit dem n\xE4chsten Start von homebot.
Feuchtesensor
Alarme und Fragen gehen \xFCber diese Adressen an Handys, Chats und E-Mail.
die Steuerung l\xE4uft nicht; sie startet von selbst neu, siehe System
gescheiterte Befehle
\u2026 und {count} weitere
es kommen keine Ereignisse mehr
mit diesem Code wurde kein Ger\xE4t gefunden; ist es bereit zum Verbinden, in diesem Netz und noch nirgends verbunden?
Gekoppelt mit {count} Steuerger\xE4ten.
erlaubt
nimmt Zahlen von 0 bis 360, 0 bis 100
{name} verwenden
Wartet auf deine Freigabe
Sabotage
Personen
das widerspricht sich; gib nur eines an
Fenster auf, hinausgehen, Hilfe rufen
fr\xFCher
, weil die Szene {scene} angewandt wurde
gespeichert
, weil die Szene {scene} r\xFCckg\xE4ngig gemacht wurde
seit {time}
nimmt nur true
der Name des Rechners ist unbekannt: berichtige die Adresse
Breite
im Haus verbergen
beobachtet: {name}
Zeilen erscheinen hier, sobald sie kommen.
beginnt mit {view}
Wohnzimmer
den Absender richten oder entfernen
nimmt einen Zeitpunkt mit Zeitzone
N\xF6tig ist: {what}
Tags nehmen keine Befehle
Hier erscheinen die Ger\xE4te dazu.
Noch meldet kein Ger\xE4t eine Temperatur.
Der Sauger reinigt einmal am Tag, wenn alle gegangen sind.
Regensensor
Eine Heizung ruht, solange ihr Fenster offen ist.
nimmt keine
neueste Version
Modell
if: was dann alles gelten muss
verlorene Nachrichten
innen
Schlafenszeit
nicht aufbewahrte Nachrichten
der Client {name}
fehlende Bibliothek
Bodenfeuchte
jeder Schritt
Dieses Bild ist nicht mehr neu.
Ank\xFCndigungen: Bytes im Speicher
nimmt on oder off
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
Bild von {name}
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
Kein Ger\xE4t dieses Hauses passt: {what}
weiter
gefunden und noch nicht benutzt
Graph
nichts davon ist bekannt, was eine Szene zur\xFCckholen k\xF6nnte
Dieser Bildschirm
Keller
es ist schon anderswo verbunden; entferne es dort oder setze es zur\xFCck
eine Bridge hat keinen Code: dr\xFCcke ihren Knopf
Er darf
verworfen f\xFCr Abwesende
zur\xFCckgewiesen
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
, wegen {what}
Mehr Bedienung
es leitet zu oft um
Name, Raum und Stichw\xF6rter
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
Name
andere
Nachts k\xFChler.
Eine Nachricht, wenn eine Pflanze Wasser braucht.
nenne ein Ger\xE4t, oder suche wie 'light in hall'
vorgeschlagen von {name}
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
am meisten {name}
nicht bekannt: {names}
harmlos
Wasser abstellen
das Protokoll hat jeden mit seiner Spur: melden oder beheben
kein Weg zu diesem Rechner
es ist kein Bluetooth-Proxy; erg\xE4nze "bluetooth_proxy:" in seiner ESPHome-Konfiguration
Bad
der Broker
Eine Nachricht, wenn ein Gefrierschrank eine Weile zu warm ist.
nichts wurde damit vereint
Verborgen
ist offen
Das steht jetzt in homebot.toml:
es hat keinen Auftrag; nenne ihm ein Ziel
Ereignisschleife
Melder
Flur
{name} freigeben
zu viele falsche Codes; nimm es kurz vom Strom
die T\xFCr ist vielleicht offen
Verriegelung
Ohne eigenen Z\xE4hler
Alles ist in Ordnung. Zu beachten:
Nachrichten
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
es gibt nichts zur\xFCckzunehmen, oder die Datei wurde seitdem ge\xE4ndert
suche \u2026
Sein letztes Ereignis, das kein Zustand ist:
es geschieht einmal und h\xE4lt nicht an
zum Haus
waagrechtes Schwenken
\xD6ffne das einmal auf dem Bildschirm; es wird nur jetzt gezeigt:
Der Ort ergibt Sonnenaufgang und Sonnenuntergang; er bleibt hier.
der Roboter hat seinen Zustand noch nicht gemeldet
Voreinstellung
es schaltet den Alarm unscharf
Sensor
die jetzigen Werte nehmen
Eine Lampe leuchtet von der D\xE4mmerung bis zur Schlafenszeit, wenn jemand zu Hause ist.
vorbehaltene Topics
abgelehnte Ger\xE4te
{name} ist verbunden.
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
du hast es {time} sp\xE4ter getan
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
gesendet in einer Nachricht an die Szene {name}
, durch ein anderes Programm
noch wurde nichts ge\xE4ndert
L\xFCfterstufe
Alles ist in Ordnung.
nimmt eine Zahl, die sein Format kennt
Es heizt bei offenem Fenster
es ist kein JPEG, PNG, GIF oder WebP bis 2 MiB
vor {time}
verworfen, weil zu gro\xDF
das Ger\xE4t oder seine Ank\xFCndigung berichtigen
Betriebsart
du, durch {what}
wenn sie startet, w\xE4hrend sie l\xE4uft
Ger\xE4te
Ausgelassen, weil geheim: {files}
Testnachricht senden
Noch ist nichts gez\xE4hlt.
homebot kann hier nicht selbst neu starten; starte es neu
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
{name} darf Ger\xE4te schalten
gib eines an, wie level 40
Druck
jedes Mal
Wassermelder
Wasserventil
Morgen
empfangen
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
Jetzt den Knopf dr\xFCcken: noch {count} s
CoAP kennt diese Methode nicht
Zuletzt hier
do: ihre Schritte, je eine Zeile
Plan mit {count} R\xE4umen
ohne Raum
gleichzeitig
Batterie l\xE4dt
Licht und eine Nachricht, wenn Wasser ist, wo keines sein soll.
{name} entfernen
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
Raum
{issuer} wurde abgewiesen: {reason}
Thema
homebot erkennt an Handys im Netz und an Trackern, wer zu Hause ist.
abwesend
Lampen gehen abends an und aus, wenn niemand zu Hause ist.
Eine Nachricht, wenn die Waschmaschine fertig ist.
seine Konvention ist ausgefallen
abgesenkt
, durch das Ger\xE4t oder einen Menschen
in diesem Browser behalten
gescheiterte Mitteilungen
Batterie, Strom, Reichweite? Ist es f\xFCr immer weg: homebot forget DEVICE
entfeuchtet
Arbeitszimmer
Warteschlangen und Verluste
Nichts Gemessenes l\xE4uft.
Was du hier \xE4nderst, zeigt jeder Bildschirm.
die Lamellen gehen nur auf (100) und zu (0)
verworfen, da zu viele
dunkel
Ohne TLS installiert ein Browser keine App: tls = true in [door].
Version
gescheiterte Verbindungen
Saugroboter
Farben
unlesbare Werte
ein Druck auf seinen Knopf
abmelden
von selbst
noch {count} s
es gibt keine Adresse: in [notify] steht keine
falsche Konfiguration
Eine Lampe wird zwanzig Minuten lang heller, bevor du aufstehst.
Es gibt kein Bild.
erneut gesendet
zeigen, was die Freigabe von {name} erlaubt
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
Ank\xFCndigungen`,n=`a person must agree: {reason}
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
jemand muss zustimmen: {reason}
ob {name} an ist, ist unbekannt; sage on oder off
kein Ger\xE4t passt zu {name}; {reason}
meintest du {name}?
nahe {name} l\xE4sst sich nichts steuern; ausgelassen: {what}
nicht, solange gilt {condition}: {name} ist unbekannt
nimmt einen Text der Form {what}
nimmt {what} nach ISO 8601
ein Befehl hat 1 bis {count}
n\xF6tig ist ein Text von h\xF6chstens {count} Zeichen
es gibt schon {count}; nimm welche zur\xFCck
kein Import nennt es; {reason}
es gibt schon {count} Entscheidungen; mache welche r\xFCckg\xE4ngig
es hat keine Ank\xFCndigung {name}; es hat {what}
die Bridge f\xFCr HomeKit kann {name} nicht \xF6ffnen: {reason}
{reason}; \`at_night\` (\`--night\`) erlaubt es
in {room} schl\xE4ft gerade jemand
nichts wurde ge\xE4ndert, denn die alten Werte lassen sich nicht aufbewahren: {reason}
es gibt kein Ger\xE4t oder Bild {name}
keine Verbindung in {count} s
es hat keine Eigenschaft {name}
kein Ger\xE4t ist erreichbar: {reason}
ein anderer Proxy hat seine Adresse {name}
die Schnittstelle {name} taugt nicht f\xFCr {value}-Multicast: {reason}
kein CoAP-Endpunkt l\xE4sst sich \xF6ffnen: {reason}
kein {value}-Multicast an der Schnittstelle {name}: {reason}
mDNS geht nicht an {name}: {reason}
es hat {name} nicht als Thema f\xFCr Befehle angek\xFCndigt
der eigene Broker kann keinen Port \xF6ffnen: {reason}
es verlangt eine andere Verschl\xFCsselung; {reason}
es verlangt {what}, eingetragen ist {name}
es verlangt {what}, das geht nicht
es verlangt Verschl\xFCsselung; {reason}
es verlangt ein anderes Passwort; {reason}
es verlangt {what}; {reason}
es verschl\xFCsselt nicht; {reason}
nimmt einen Text von {least} bis {most} Zeichen
nimmt einen Text von h\xF6chstens {count} Zeichen
nimmt einen Text von h\xF6chstens {what}
seine Vorlage scheitert: {what}
seine Vorlage {what}
es l\xE4sst sich nicht als {what} kodieren
Home Assistant hat sich in {count} s nicht gemeldet
es w\xFCrde bis {least} \xB0C heizen und bis {most} \xB0C k\xFChlen
HAP-Status {count}
die Bridge von {name} ist nicht verbunden
Knoten {count} ist in Betrieb, aber der Gateway hat schon max_nodes
der Matter-Gateway hat kein Ger\xE4t {name}
das Ger\xE4t antwortet mit dem Status {what}
das Ger\xE4t antwortet mit dem Fehler {what}
die Adresse {name} ist unbekannt: {reason}
der Inhaltstyp {name} wird nicht verstanden
die Beobachtung von {name} ist zu Ende
in {name} lassen sich keine Kopien anlegen: {reason}
nimmt {what}, und keine \xC4nderung
es bietet nicht: {what}
es hat kein Skript {name}; eine Tabelle [[gateways.ble.proxies]] installiert es
der Roboter nimmt im Modus {what} keine Auftr\xE4ge
die Tabelle {name} darf eine Seite nicht \xE4ndern, nur: {what}
der Schl\xFCssel {name} l\xE4dt ein Programm oder eine Datei; trage ihn selbst ein
das Recht {name} darfst du nicht geben; nimm: homebot token new
keine Sicherung hat ein Byte {count}; beginne bei 0
die \xC4nderung {name} nennt nichts
die Adresse {name} steht nicht mehr in der Datei; sieh noch einmal nach
Gateway {name} ist weg: {reason}
{name} hat in {count} s nicht geantwortet; ob es geschah, ist unbekannt
abgelehnt ({value}): {reason}
ging nach {count} s zur\xFCck, {value}
nicht gesendet: {reason}
widersprochen: {reason}
der Name des Rechners l\xE4sst sich gerade nicht aufl\xF6sen ({what})
{name} hat den Aufzug
{value} hat die Verbindung beendet
{name} ist nicht verbunden: {reason}
{name} ist nicht verbunden
{name} hat in {count} s nicht geantwortet
{name} schl\xE4ft; versuche es wieder, wenn es wach ist
{name} ist in Home Assistant nicht verf\xFCgbar
Home Assistant hat keine Entit\xE4t mehr f\xFCr {name}
{name} hat keinen Treiber; \`homebot doctor\` nennt, was nicht nutzbar ist
dem Zertifikat von {name} wird nicht vertraut
{what}: der Server antwortet {count}, sp\xE4ter geht es vielleicht
der Server antwortet {count}
es verlangt ein Passwort (Status {count})
mit diesem Passwort l\xE4sst es homebot nicht ein (Status {count})
nimmt nicht: {value}
nimmt eine Zahl von {least} bis {most}
es hat diese Einstellung nicht; es nimmt {list}
{name} hat keine \xC4nderung gemessen
es gibt kein Ger\xE4t {name}
niemand ist in {room}
{name} hat noch nie jemanden bemerkt; gehe einmal daran vorbei
{name} meldet sich erst seit {count} s
{reason}, und der Zugang darf nur {what}; erg\xE4nze {right} in der Tabelle [{table}] von homebot.toml
{reason}, und der Zugang darf nur {what}
ein solches Ger\xE4t braucht ein Recht, das es nennt ({reason})
{what}, und das geht noch {count} s vor
{value}, nach einer alten Meldung: gerade nicht erreichbar
{value}, nach einer alten Meldung: zuletzt geh\xF6rt vor {age}
{value}, nach einer aufbewahrten Meldung: es hat sich noch nicht selbst gemeldet
{name} hei\xDFt jetzt {what}
{name} ist abgelehnt und kommt nicht wieder
{name} l\xE4uft nicht: {reason}
eine Routine oder App {name} gibt es schon; w\xE4hle einen anderen Namen, oder \xE4ndere jene
{name} steht in der Konfiguration; \xE4ndere es dort, und dann: {what}
nichts r\xFCckg\xE4ngig zu machen: {name} wurde nicht angewendet, oder es ist schon geschehen
von {name} ist nichts mehr zur\xFCckzuholen
die Szene {name} gibt es schon
{name} ist gerade nicht im Haus; lass es, wie es ist, oder weg
es d\xFCrfen {count} sein; entferne zuerst eines
{name} wurde inzwischen ge\xE4ndert; sieh es an, und versuche es noch einmal
{name} gibt es schon; entferne es, oder nenne den Gateway anders
{reason}, darum nur mit seinem Namen: {what}
es ist nicht verbunden: {what}
{name} ist nicht mit homebot verbunden
das letzte Neuladen wurde abgelehnt: {reason}
keine Antwort in {count} s
zu viele Codes ohne bekannte Wirkung von {issuer}
nicht, solange gilt {condition}, und der Zustand von {name} ist unbekannt: {reason}
jemand ist in {room}: {name} war vor {count} s an, und seitdem ging keine T\xFCr auf
vielleicht ist jemand in {room}: {name} \xE4nderte sich vor {count} s, und kein Befehl erkl\xE4rt es
{name} braucht ein Recht, das es nennt ({reason}), und {issuer} hat keines{what}
{name} braucht ein Recht, denn {reason}, und {issuer} hat keines{what}
es steht nicht auf der Liste harmloser Ger\xE4te ({what})
auf {value} gehalten von {holder}, bis es freigegeben wird
noch {count} s auf {value} gehalten von {holder}
gehalten von {holder}, bis es freigegeben wird: {value}
noch {count} s gehalten von {holder}: {value}
{name} hat nein gesagt
niemand hat in {count} s geantwortet: das geht auf der Seite oder mit \`homebot answer\`
es ist {time}, und Ruhe von {start} bis {end}
jemand ist in {room}: {what}
vor {count} s war jemand in {room}: {what}
vielleicht ist jemand in {room}: {what}
unbekannt, ob jemand in {room} ist: {reason}
{name} wurde in {span} s {count}-mal hin und her geschaltet
nicht, solange gilt {condition}: {what}
das Mitglied {name} lehnt ab: {reason}
{issuer} darf {name} nicht steuern, nur: {what}
{issuer} darf {name} nicht steuern: {reason}
kein Ger\xE4t ist erreichbar: {reason}
{name} ist nicht erreichbar: {reason}
{name} ist gerade nicht im Netz
die Verbindung zu {name} ging verloren
Art: {value}
Art: {value}
es nennt sich {name}
seine Einheit ist {name}
es heizt bis {count} \xB0C
neben einem anderen Teil: {reason}
der Name {name} sagt {what}
das Modell {name} sagt {what}
Gateway {name} meldet seinen Zustand nicht
Problem von {name}
aufgegeben von {name}
Fehler in {name} seit dem Start
gez\xE4hlt von {name} in den letzten zehn Minuten
gez\xE4hlt von {name} seit dem Start
in Quarant\xE4ne bei {name}, das nur einen Teil ihrer Nachrichten liest
Hinweis zu {name}
Gateway {name} ist {value} und sendet Befehle
Gateway {name} ist {value} und beobachtet nur: {reason}
Gateway {name} ist {value} und beobachtet nur
Gateway {name} ist {value}: {reason}
{reason} Nach dem Neustart von homebot gilt: {keys}
Die Datei ist wie vorher: {reason}
{count} Ger\xE4te warten auf Freigabe und bekommen vorher keine Befehle: {list}
1 Ger\xE4t wartet auf Freigabe und bekommt vorher keine Befehle: {list}
die letzte Nachricht wurde nicht gesendet: {reason}
zuletzt geh\xF6rt vor {age}
erledigt: {what}
ausgelassen: nicht {what}
{what} ging nicht: {reason}
{value} ({count} %)
{value}, seit {age}
{name} ist nicht ungef\xE4hrlich ({reason}), und {value}; freigeben mit {what}
die Regel ist ausgefallen: {what}
{count} Befehle warten noch auf ihren Ausgang
sein Gateway {name} ist {value}: {reason}
sein Gateway {name} ist {value}
{name} hat in {count} s nicht geantwortet: {what}
niemand h\xF6rt auf {what}
sein Knopf wurde in {count} s nicht gedr\xFCckt; dr\xFCcke ihn und versuche es noch einmal
{name} wurde nicht verbunden: {reason}
{what} wurde abgelehnt: {reason}
{name} hat kein Bild
{id}: {name} hat von seinem letzten Befehl nichts bemerkt; nach der Reparatur \`homebot trust {what}\`
{name} ({reason})
nimmt: {what}
dieser Teil nimmt: {list}
keiner seiner Modi: {list}
das Ger\xE4t antwortet: {what}
{name} ist schon mit homebot verbunden
{name} geh\xF6rt zur Bridge {what}, die als Ganzes verbunden wird
{reason}; wieder in {count} s
von hier geht nur: {value}
den Raum {name} gibt es schon
{name} hei\xDFt schon so
{name} ist mit einem anderen System verbunden; trenne es dort oder setze es zur\xFCck, dann {what}
{name} ist entfernt
{name} ist ge\xE4ndert
{name} ist hinzugef\xFCgt
{name} hat ja gesagt
{name} antwortet nicht
{name} hat nicht geantwortet
{name} nimmt keine Befehle, die homebot kennt
{count} Ger\xE4te passen zu {name}; h\xF6chstens {most} gehen auf einmal
{what} wurde nicht an {name} gesendet: {reason}
{what} wurde an {name} gesendet: {reason}
{what} von {name}: {reason}
{name} hat schon {what}
{name} hat keinen Teil
{name} ist mit TLS nicht erreichbar: {reason}
{count} Bluetooth-Proxys sind schon verbunden
{name} braucht l\xE4nger als {count} s f\xFCr eine Antwort
{name} ist an keinem Endpunkt bekannt
{name} hat keine HTTP-Adresse
{name} hat keine Adresse
{name} beantwortet keine Anfragen
{name} nimmt keine Nachricht
{name} hat die Ereignisse beendet
{name} l\xE4sst sich nicht als {what} ank\xFCndigen: {reason}
{name}: {count} Befehle warten schon auf {what}
{name} l\xE4sst sich nicht \xF6ffnen: {reason}; {what}
{name} l\xE4sst sich nicht \xF6ffnen: {reason}
{name} wurde nicht gesetzt: {reason}
{name} wird mit dem Code darauf verbunden: {what}
{name} ist schon in Betrieb genommen
{name} geh\xF6rt zur Bridge {what} ({id}); nur die Bridge l\xE4sst sich entfernen
{name} antwortet dem Matter-Server nicht
{name} hat sich noch nicht beschrieben
{what} von {name} l\xE4sst sich nicht setzen
{name} l\xE4sst sich nicht schreiben: {reason}
{name} l\xE4sst sich nicht beiseitelegen: {reason}
{name} ist nicht offen
{name} l\xE4sst sich nicht kopieren: {reason}
{name} l\xE4sst sich nicht neu anlegen: {reason}
{name} von {what} passt in keine eigene Datei
{name} = {what} ist kein Wert von TOML; Texte brauchen Anf\xFChrungszeichen
{name} geht nicht als Name: nimm bis {count} druckbare Zeichen
{name} geht nicht ({what}): {reason}`;export{n as reasons,e as texts};
