var e=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 3k4 il 1ow 109 1qe 44w 3z id 7yk 5qv 1nc 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 3gk 1 1qf 390 312 1on 84 93w 56y 5g 1sr 1 7lm 7i6 nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt jf 6vj 1al 2a4 71r 64j 38b 3b2 43 1z3 17l 6k gl7 58 1im 2ep 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 557 8li 233 5kk 463 101 1lp 2vn 2u5 41m 11l 58d 23v o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 5ks hh 4e rd 1ei 1c3 h6 6n 6tg 19i ij 243 us ss 1ek md 4ku 353 2h1 z1 4ys 6nt 2xg 9nj 88c ji f2 gv eri py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 9ib 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 6lu 2vv y2 7xl 1cg d4j 2hy 1yk kc vp 8i9 3mx 70 1cw xs 507 24o 1n8 1lj 1wx 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 7am 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 3jn hyb ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 1to 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np 7db 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1oh 3ne 18n 3yv 2la 16 2sf 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 219 4be 2r2 3uo 39k 269 oi 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 2b6 7o 6ev 3ei 2xk 3ug 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3r9 1qr el rb 2ih 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 4dd 6i4 811 2kh 57s 1k9 1cg 2eh 38c 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 8v0 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 3pq 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2te 5x2 7nh i2 9h8 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 2fr 3 5tk 6u b34 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 3u8 rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 3q3 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 1xq a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe aor 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
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
lief
Rohdaten
Tag
ohne Token weiter
{issuer} wollte {values}
Fernseher
Feinstaub PM10
du hast es {time} vorher getan
wird gesendet \u2026
Verlauf
die Kopplungen mit Apple Home
ein unbekanntes Programm
das Recht geben
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
Anwesenheit
die letzten 24 Stunden
Ein Server auf diesem Rechner
Titel
Verbindung
Ein L\xFCfter l\xE4uft, solange das Bad feucht ist.
verlorene R\xFCckmeldungen
homebot neu starten
Es gibt kein Ger\xE4t {name} (mehr).
von Hand oder von selbst
homebot why GER\xC4T zeigt die Meldungen
homebot l\xE4uft zur Probe und sendet nichts
Benutzer
es hat sich seitdem ver\xE4ndert; sieh es noch einmal an
gesendet in einer Nachricht an die Gruppe {name}
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
es hat sich seit deiner Freigabe ver\xE4ndert
{what} im Lauf der Zeit, {count} Punkte
Noch ist nichts geschehen.
Licht, solange sich jemand bewegt und es dunkel ist; eine Lampe, die schon an ist oder die jemand inzwischen schaltet, bleibt wie sie ist.
Wer sie jetzt braucht
nicht verf\xFCgbar
Ein Token gibt dieser Seite ihre Rechte: Deines ist die Zeile in owner.token, im Datenordner von homebot. F\xFCr ein Tablet erzeugst du eines mit:
K\xFChler, wenn niemand zu Hause ist, wieder warm mit dem Ersten, der kommt.
, durch einen Menschen
Wie ntfy://TOPIC oder mailto://USER:PASSWORD@HOST; appriseit.com nennt alle.
die Verbindung wurde beendet
nichts tun
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
mit diesem Code wurde kein Ger\xE4t gefunden; ist es bereit zum Verbinden, in diesem Netz und noch nirgends verbunden?
Gekoppelt mit {count} Steuerger\xE4ten.
erlaubt
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
der Name des Rechners ist unbekannt: berichtige die Adresse
Breite
im Haus verbergen
beobachtet: {name}
Zeilen erscheinen hier, sobald sie kommen.
beginnt mit {view}
Wohnzimmer
den Absender richten oder entfernen
N\xF6tig ist: {what}
Hier erscheinen die Ger\xE4te dazu.
Noch meldet kein Ger\xE4t eine Temperatur.
Der Sauger reinigt einmal am Tag, wenn alle gegangen sind.
Regensensor
Eine Heizung ruht, solange ihr Fenster offen ist.
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
Dieser Bildschirm
Keller
es ist schon anderswo verbunden; entferne es dort oder setze es zur\xFCck
Er darf
verworfen f\xFCr Abwesende
zur\xFCckgewiesen
Zu zwei Dritteln herunter, solange es hei\xDF ist.
{least} bis {most}
Eine Nachricht, wenn ein Fenster offen bleibt, w\xE4hrend es drau\xDFen kalt ist.
Eine Nachricht, wenn eine Weile viel Strom verbraucht wird.
in Ruhe
Plan wird geladen \u2026
schlie\xDFen
Betriebsart
T\xFCren und Fenster
erreicht \xFCber
es steht in der Konfiguration; \xE4ndere dort [places]
, wegen {what}
Mehr Bedienung
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
verworfene Anfragen
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
Bad
der Broker
Eine Nachricht, wenn ein Gefrierschrank eine Weile zu warm ist.
Verborgen
ist offen
Das steht jetzt in homebot.toml:
Ereignisschleife
Melder
Flur
{name} freigeben
zu viele falsche Codes; nimm es kurz vom Strom
T\xFCr vielleicht offen
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
jetzt ausf\xFChren
Der Code, den homebot run ausgibt, l\xE4sst den ersten Bildschirm ein.
eingespeiste Energie
gescheiterte Anmeldungen
niemand hat es erfahren; [notify] und das Log sagen, warum
Bildschirme
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
homebot show GER\xC4T
Ordner f\xFCr Daten
Sieben Tage
Ortung
von Hand
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
zum Haus
waagrechtes Schwenken
\xD6ffne das einmal auf dem Bildschirm; es wird nur jetzt gezeigt:
Der Ort ergibt Sonnenaufgang und Sonnenuntergang; er bleibt hier.
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
Keine App l\xE4uft.
Routinen werden geladen \u2026
eine Minute warten, dann das Protokoll ansehen
mehrere Namen f\xFCr eine Kennung: vielleicht mehrere Ger\xE4te
Haushalt
Stockwerk
das Ger\xE4t l\xE4sst sich nur ausschalten, wie ein Herd zur Sicherheit
noch nicht verbunden
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
danach
versp\xE4tet um
strittig
{name} darf Ger\xE4te schalten
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
zusehen
verloren
Antworten
Jetzt den Knopf dr\xFCcken: noch {count} s
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
Ank\xFCndigungen`,n=`gateway {name} is away: {reason}
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
Gateway {name} ist weg: {reason}
{name} hat in {count} s nicht geantwortet; ob es geschah, ist unbekannt
abgelehnt ({value}): {reason}
ging nach {count} s zur\xFCck, {value}
nicht gesendet: {reason}
widersprochen: {reason}
der Name des Rechners l\xE4sst sich gerade nicht aufl\xF6sen ({what})
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
{name} hat nicht geantwortet`;export{n as reasons,e as texts};
