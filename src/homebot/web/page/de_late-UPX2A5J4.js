var e=`4w2yoNyHmVAl09JSb1NUOOirW8plFHRXtoNfHkuybiocTfoahynbfyP1GPQaNnRXZCvyxccMMyvPypvwg76kJp2QMy4SOPRECIhCpzXzfbx4T80oh8Zuu9YiPab6ybBLWagnQQfpzBOax2M8kz7jw8RDnvVACvROUyfaDvvrm3QJ48RzFkJQnR119wIOs8mtfKz045Jq8LKvOWOIPSPADpsKsnpVxtadOknuuLFl08uANUYifxMX57yxIVrRAgNjakuUPlXUJRz229N4h7YiSrl0ucJNAsLrF72Cy7TQOBodiB6wv9HbtJlBaY8WMk0dRFCV5wgN4LMOviw7mUsPfTjPSAnDM760XnVNoC1pLb2iNuk3JilUxTWUlKxgMtGnQMUwOMF4X4rnqr3K8uAXwt6oMchLyFuQmG2zxWv3TSozKzjfJJ20IkflBhAZAQMEonNJFALraLUVaBRQv7Pm17tJlbfXOgOYKIcca5aoUFqVYPLYzfJ9H7p100c7j5s0F6vSx7pVpsb8tyLBlYVsYZYdefNfeQJ5BDnOrdCuPG9tJAAa2PIky57Bpq6PNgqWfvADAPXkYaSp3VyzgubmDqTrJlSMApfmWMy35Dko0jQDW85dT9beSDrK0BN65ziwEBbuFBiSdpcMIVfHr6HQx8vMAacS0rDCuaL26wCylUAQ2PWpkIJYpBGu7qrDCIITmKuCUxpQVkhGFzHNxugHA8mehzaMmx49gB8hAXyZZyqsepVeDS7c2pPHzrrjQ1Tfnrz8X5lg8plp005MWaYBEoLcU9ezCgQZLI47Q3gKy9Iz7zeWgV97tgFTNtYz1rEaUoKT3JPvocErs8fC0Cpi0FAdXe6Qn4EuNu7fHnzKLioPIRIOQhvGVnAKufCzBt7eh8urvvu9TAhtlVMHTVJFYXrVlfMW9ShxcFmPP4lh8M7JW5K8Cz6IqozuA5ASXGKKJ1bvFTYKEHOYYBwzgCwfwbQb7HLWJNroAqvAttjuu6B3Qg7pHKPF9G37m50QyWmDlhql4zhwWl6NIrjSeE9dV7yTp5PaQSLmaY2iaExHUlJMcm6fMqU3X3xKoKtlbT8T2tnb69haSy8fr9fQTh0FPRxg3EnWIJYjeK3flG4EXUkBt5InRFBykHFGlrT2Wa4oX5v11QgBySOYEefEjmDKVm4ne1UldSlWYyLQ4F4JndG3tq0yHIWDEDTkWNZdqwdOB6NI034RE0eOA825ALtFLdVfuNROVdQKyYhtIGkM7YGrw7UATucq2PfSpUfwx2NLPDlsWbu0oTMLhhw3zqewGbamRhDn44uAxM1vBzE9NnMUuZNMAhb36mpYEumh6lyKXzeqs9fChC2Df0UI7WMkGz476UKewHsGHbrB91oWe6oetmWXtSMG7f4JUJDjQ0M3EDHWnjgDKdnBdMavDxB0RJEgHKOUMkq6mYTAtk37gXpzWZX6LvccJYBW7hxVYC5ZzCm4Wv0PdU2ikP3LuihkUd1Y2Y1rvoXNxxzeIVBVDY3ZFOjovy1eQbJDnildfmZpCOOzSyiqGPAiE6Iv549Uc0zMQn1kdr5E4BtLy0S1wSC1lHnPBOc9tMBTvw2ucf4oRBpIaMtghXUutHTUwYhQkd7ktG2j0qbN8NHnIc7udk3WY9kWWUJ4WTONgrnQ2ZSaHyuGCMWB3WMHk3VjXHf6LVEW8QLGbEweWRkqwMRw91VUByDy3zqCuIby2wKxezVIwZuTlY6KHNpbDQGDUdYTLMQFfAzaEzDmFmTb7xqKIM
Was du hier \xE4nderst, zeigt jeder Bildschirm.
r\xFCckg\xE4ngig
fr\xFCher
nicht hier
verbergen
Verborgen
anmelden
abmelden
An einer Wand
beginnt mit {view}
in Ruhe
Nach f\xFCnf Minuten zeigt er eine dunkle Uhr und was offen ist. Die Adresse dieses Bildschirms:
Ohne TLS installiert ein Browser keine App: tls = true in [door].
Das Zertifikat, dem deine Ger\xE4te vertrauen sollen
Sprache
Ein Token gibt dieser Seite ihre Rechte: Deines ist die Zeile in owner.token, im Datenordner von homebot. F\xFCr ein Tablet erzeugst du eines mit:
Token
in diesem Browser behalten
ohne Token weiter
setzen
{least} bis {most}
Name
Stichw\xF6rter
Name, Raum und Stichw\xF6rter
ein neuer Raum
im Haus verbergen
speichern
gespeichert
Ohne eigenen Z\xE4hler
Es gibt kein Ger\xE4t {name} (mehr).
Werte
seit {time}
Befehle
Warum
Sein letztes Ereignis, das kein Zustand ist:
Es hat noch keine \xC4nderung gemeldet.
Es ist so, seit homebot davon wei\xDF.
Eine aufbewahrte Nachricht sagt es, aber nicht seit wann.
Es war so bei der ersten Meldung.
Es hat sich um {time} ge\xE4ndert.
Was bekannt ist, und woher
Nicht verstanden um {time}:
zuletzt geh\xF6rt
vor {time}
du, durch {what}
erreicht \xFCber
Widerspruch
Verlauf
Aus dieser Zeit ist nichts gespeichert.
Energie je Tag
{energy} eingespeist
Energie am {day}
Plan wird geladen \u2026
Noch hat kein Raum eine Form. Gib ihm Ecken in der Tabelle [places.rooms], oder lies eine Karte ein: homebot places import DATEI.
Erdgeschoss
Plan mit {count} Raum
Plan mit {count} R\xE4umen
Ein voller Punkt ist an, offen oder belegt.
au\xDFerhalb aller R\xE4ume
gerade nicht bekannt
Routinen werden geladen \u2026
Noch gibt es keine Routine.
neue Routine
vorgeschlagen von {name}
als N\xE4chstes
letzte L\xE4ufe
jetzt ausf\xFChren
das Recht geben
diese Routine {names} schalten lassen
darf schalten
, weil die Szene {scene} angewandt wurde
, weil die Szene {scene} r\xFCckg\xE4ngig gemacht wurde
gesendet in einer Nachricht an die Gruppe {name}
gesendet in einer Nachricht an die Szene {name}
Ein Ger\xE4t ohne Wert geh\xF6rt nicht mehr dazu.
Sie beh\xE4lt die jetzigen Werte von:
Es gibt nichts vorzuschlagen.
Was diese Szene verwahrt, sagt ihre Werte nicht.
Deine Gewohnheiten
annehmen
ablehnen
behalten
jedes Mal
homebot sucht im Verlauf von vier Wochen, was du immer wieder tust, und beobachtet es eine Woche, bevor es das vorschl\xE4gt.
beobachtet: {name}
nach Gewohnheiten suchen
suche \u2026
{name} entfernen
die jetzigen Werte nehmen
du hast es {time} sp\xE4ter getan
du hast es {time} vorher getan
du hast es nicht getan
In der Probewoche hast du das {done} von {total} Malen getan; eine Routine h\xE4tte in {low} bis {high} % der F\xE4lle recht.
when: was sie startet, je eine Zeile
if: was dann alles gelten muss
do: ihre Schritte, je eine Zeile
wenn sie startet, w\xE4hrend sie l\xE4uft
der Text
jeder Schritt
Keiner der neuesten {count} Eintr\xE4ge hat diese W\xF6rter.
Noch ist nichts geschehen.
neueste zuerst
der Client {name}
ein unbekanntes Programm
{issuer} wollte {values}
gesendet
erneut gesendet
das Netz hat es angenommen
meldete {values}
ge\xE4ndert zu {values}
{issuer} sandte {text}
{issuer} wurde abgewiesen: {reason}
durch {issuer}
, weil {device} {values} meldete
, wegen {what}
, unterwegs
, ein Echo
, von selbst
, durch einen Menschen
, durch ein anderes Programm
, durch das Ger\xE4t oder einen Menschen
erlaubt
Gateway
homebot wird befragt \u2026
Diagnose
Alles ist in Ordnung.
Alles ist in Ordnung. Zu beachten:
\u2026 und {count} weitere
Apps
Keine App l\xE4uft.
Noch ist nichts gez\xE4hlt.
Protokoll
Zeilen erscheinen hier, sobald sie kommen.
Wartet auf deine Freigabe
zeigen, was die Freigabe von {name} erlaubt
zeigen
Die Freigabe erlaubt diese Befehle:
Seit der letzten Freigabe ge\xE4ndert:
{name} freigeben
Graph wird geladen \u2026
Zeige
Knoten links ver\xF6ffentlichen Themen, Knoten rechts abonnieren sie.
Graph
{nodes} Knoten und {topics} Themen
Die ersten Werte kommen in zwei Sekunden.
Nachrichten
{what} im Lauf der Zeit, {count} Punkte
Nachrichten je Sekunde
Warteschlangen und Verluste
wartende und verlorene Nachrichten
wartend
verloren
Ereignisschleife
Verz\xF6gerung der Ereignisschleife
versp\xE4tet um
Die meisten Nachrichten
Thema
Langsamster Empf\xE4nger
Raum
jetzt
Roboter
Tag
abwesend
l\xE4uft
Farben
wie das System
hell
dunkel
Dieser Bildschirm
T\xFCren und Fenster
Rauch, Wasser, Bewegung
Favorit
Es heizt bei offenem Fenster
Zuletzt hier
Mehr Bedienung
Noch meldet kein Ger\xE4t eine Temperatur.
Noch meldet kein Ger\xE4t Leistung oder Energie.
Nichts Gemessenes l\xE4uft.
Jetzt
Heute
Sieben Tage
Wer sie jetzt braucht
am meisten {name}
{energy} kWh an anderen solchen Tagen
Das Haus ist offen
Das Haus ist zu
Noch gibt es weder Schloss noch Kontakt noch Alarm.
Es gibt kein Bild.
Dieses Bild ist nicht mehr neu.
Werte, Verlauf, Fakten
nicht bekannt: {names}
die letzten 24 Stunden
Name und Ort
Ger\xE4te
Bildschirme
schreibe \u2026
Das steht jetzt in homebot.toml:
r\xFCckg\xE4ngig machen
weiter
zum Haus
Zeitzone
Breite
L\xE4nge
Der Ort ergibt Sonnenaufgang und Sonnenuntergang; er bleibt hier.
wo dieser Bildschirm ist
Ein Server auf diesem Rechner
{name} verwenden
{name} darf Ger\xE4te schalten
Hinzuf\xFCgen
Adresse
Benutzer
Passwort
Neue Gateways beginnen mit dem n\xE4chsten Start von homebot.
homebot neu starten
Jedes Ger\xE4t hat einen Raum.
Noch ist kein Ger\xE4t da.
Jeder Bildschirm hat ein eigenes Token, das man ihm nehmen kann.
Er darf
zusehen
zusehen und schalten
alles
Token erzeugen
\xD6ffne das einmal auf dem Bildschirm; es wird nur jetzt gezeigt:
Token oder Code
Der Code, den homebot run ausgibt, l\xE4sst den ersten Bildschirm ein.
K\xFCche
Wohnzimmer
Schlafzimmer
Bad
Flur
Arbeitszimmer
Garten
Garage
Keller
Terrasse
Fertige Routinen
fertige Routinen
Kein Ger\xE4t dieses Hauses passt: {what}
zur\xFCck
Heizung
Personen
Alarme
Sicherung
Person
Handy im Netz
\xE4ndern
wird gesendet \u2026
verbinden
homebot erkennt an Handys im Netz und an Trackern, wer zu Hause ist.
Alarme und Fragen gehen \xFCber diese Adressen an Handys, Chats und E-Mail.
Die Testnachricht ist verschickt.
Testnachricht senden
Wie ntfy://TOPIC oder mailto://USER:PASSWORD@HOST; appriseit.com nennt alle.
Sie enth\xE4lt alles, was homebot aufbewahrt, aber keine Passw\xF6rter.
In der App Home: +, Ger\xE4t hinzuf\xFCgen, und dies scannen oder den Code eingeben.
Gekoppelt mit {count} Steuerger\xE4ten.
die Kopplungen mit Apple Home
QR-Code
Sicherung erstellen
Sie wird erstellt \u2026
{name} ist heruntergeladen ({size} kB).
Zum Zur\xFCckspielen:
Ausgelassen, weil geheim: {files}
Der Code auf dem Ger\xE4t
Dr\xFCcke den Knopf am Ger\xE4t, dann \u201Everbinden\u201C.
noch {count} s
Jetzt den Knopf dr\xFCcken: noch {count} s
{name} ist verbunden.
Gefunden:
Hier erscheinen die Ger\xE4te dazu.
N\xF6tig ist: {what}
ein Druck auf seinen Knopf
Rauch oder Hitze
Wasser l\xE4uft aus
Sabotage
lange offen
schwache Batterie
Brennt es? Verlasst das Haus und ruft die Feuerwehr
Fenster auf, hinausgehen, Hilfe rufen
Keine Flamme, kein Schalter; Fenster auf, hinausgehen, Hilfe rufen
Wasser abstellen
schlie\xDFen
Ist das Geh\xE4use offen, oder ist es von der Wand?
Batterie, Strom, Reichweite?
wechseln oder laden
homebot show GER\xC4T
homebot why GER\xC4T zeigt die Meldungen
wann
falls
tu
nichts tun
neu beginnen
danach
gleichzeitig
Rechte
R\xFCckfrage
immer fragen
Freigabe
harmlos
Anwesenheit
Ruhezeit
H\xE4ufigkeit
Verriegelung
Hersteller
Modell
T\xFCrschloss
Rollladen oder Vorhang
Klimaanlage
Wasserventil
Saugroboter
Warmwasserbereiter
Luftbefeuchter
Rasenm\xE4her
Alarmanlage
Kontaktsensor
Bewegungsmelder
Rauch- oder CO-Melder
Wassermelder
Regensensor
Frostmelder
Luftqualit\xE4tssensor
Bodensensor
Temperatursensor
Feuchtesensor
Helligkeitssensor
Drucksensor
Durchflusssensor
Taster
Stromz\xE4hler
Fernseher
Haushalt
Ortung
Tag-Leser
Sensor
Melder
Einstellung
Aktualisierung
alle zu Hause
entfeuchtet
Farbtemperatur
Drehzahl
Raumtemperatur
Betriebsart
T\xE4tigkeit
Voreinstellung
Schwenken
waagrechtes Schwenken
L\xFCfterstufe
Betriebsart
Betriebsart
Sirenenton
Suchen
Rohdaten
Version
neueste Version
Bild
Wasser
Verbindung
Batterie l\xE4dt
Druck
Durchfluss
eingespeiste Energie
Frequenz
Kohlendioxid
Kohlenmonoxid
Feinstaub PM10
Feinstaub PM1
fl\xFCchtige Stoffe
Luftqualit\xE4t
Bodenfeuchte
Signalst\xE4rke
Bild von {name}
feucht ab
Klingel
Helligkeit
Schlafenszeit
Gefrierschrank
Grenze
nach
Uhrzeit
Morgen
Abend
offen seit
abgesenkt
Z\xE4hler
lang
Bewegung
dunkel unter
beginnt
endet
Pflanze
andere
innen
hei\xDF ab
Tage
bleibt
kalt unter
Ein L\xFCfter l\xE4uft, solange das Bad feucht ist.
Ein Taster schaltet eine Lampe.
Sofort eine Nachricht, wenn eine T\xFCr aufgeht und niemand zu Hause ist.
Ein Klingeln wird gemeldet und macht im Dunkeln Licht am Eingang.
Eine Lampe leuchtet von der D\xE4mmerung bis zur Schlafenszeit, wenn jemand zu Hause ist.
Eine Nachricht, wenn ein Gefrierschrank eine Weile zu warm ist.
Eine Nachricht, wenn die Garage offen bleibt, und immer wieder.
Ein Druck am Bett: alle Lichter aus, und eine Nachricht, wenn etwas offen ist.
K\xFChler, wenn niemand zu Hause ist, wieder warm mit dem Ersten, der kommt.
Nachts k\xFChler.
Morgens und abends warm.
Eine Heizung ruht, solange ihr Fenster offen ist.
Eine Nachricht, wenn die Waschmaschine fertig ist.
Alle Lichter gehen aus, sobald alle gegangen sind.
Licht, solange sich jemand bewegt und es dunkel ist; eine Lampe, die schon an ist oder die jemand inzwischen schaltet, bleibt wie sie ist.
Ein schwaches Licht f\xFCr den Weg in der Nacht.
Eine Nachricht, wenn eine Pflanze Wasser braucht.
Eine Nachricht, wenn eine Weile viel Strom verbraucht wird.
Lampen gehen abends an und aus, wenn niemand zu Hause ist.
Zu zwei Dritteln herunter, solange es hei\xDF ist.
In der D\xE4mmerung herunter, am Morgen herauf.
Eine Steckdose geht nachts aus, wenn ihr Ger\xE4t nur wartet.
Der Sauger reinigt einmal am Tag, wenn alle gegangen sind.
Eine Lampe wird zwanzig Minuten lang heller, bevor du aufstehst.
Licht und eine Nachricht, wenn Wasser ist, wo keines sein soll.
Licht im Flur, wenn die Haust\xFCr im Dunkeln aufgeht.
Eine Nachricht, wenn ein Fenster offen bleibt, w\xE4hrend es drau\xDFen kalt ist.
falsche Konfiguration
berichtigen, dann: homebot config check
fehlende Bibliothek
Ordner f\xFCr Daten
zu deinem machen oder in HOMEBOT_DATA einen anderen nennen
Datei mit Daten
das neuere homebot wieder installieren oder: homebot restore BACKUP
Port
l\xE4uft homebot schon, frage es: homebot doctor
nicht erreichbar
eine Minute warten, dann das Protokoll ansehen
die Ursache im Protokoll beheben, dann: homebot app reload APP, oder homebot neu starten
Batterie, Strom, Reichweite? Ist es f\xFCr immer weg: homebot forget DEVICE
strittig
homebot show DEVICE zeigt beide Seiten; homebot forget DEVICE beendet es
das Protokoll hat jeden mit seiner Spur: melden oder beheben
das Protokoll und homebot journal sagen mehr
den Absender richten oder entfernen
sendet, was seine Ank\xFCndigung nicht erkl\xE4rt
das Ger\xE4t oder seine Ank\xFCndigung berichtigen
Geheimnis
mehrere Namen f\xFCr eine Kennung: vielleicht mehrere Ger\xE4te
gib jedem Ger\xE4t in seinen Ank\xFCndigungen eine eigene Kennung; bis dahin hei\xDFen seine Teile so
ohne Raum
Saugroboter, die noch keine Roboter sind
die Tabelle erg\xE4nzen und homebot neu starten: docs/robots.md
gefunden und noch nicht benutzt
homebot nach einer neuen Tabelle neu starten: docs/protocols.md
empfangen
zur\xFCckgewiesen
abgelehnte Befehle
gescheiterte Befehle
Ank\xFCndigungen
mehrdeutige Ank\xFCndigungen
abgelehnte Ank\xFCndigungen
abgeleitete Ank\xFCndigungen
aufgeschobene Ank\xFCndigungen
\xFCbergangene Ank\xFCndigungen
Ank\xFCndigungen: Bytes zu viel
Ank\xFCndigungen: Bytes im Speicher
abgelehnte Ger\xE4te
abgelehnte Topics
vorbehaltene Topics
abgelehnte Typen
abgelehnte Adressen
Meldungen
abgelehnte Werte
zu lang
unlesbare Werte
Fehler
verworfene Anfragen
verworfene Abl\xE4ufe
Quarant\xE4nen
vergessene St\xF6rer
Antworten
sp\xE4te Antworten
unbekannte Antworten
verworfen, da zu viele
verworfen, da zu lang
verworfen, da entstellt
in Betrieb
nicht verf\xFCgbar
hoch
niedrig
normal
meldet Rauch oder Hitze
meldet Kohlenmonoxid
meldet Gas
ist nass
hat ausgel\xF6st
meldet einen Eingriff
meldet ein Problem
ist offen
hat eine schwache Batterie
lief
es hat seit dem Start von homebot noch nichts gemeldet
es ist nicht erreichbar
es ist zu lange stumm
es ist nicht freigegeben
es wurde erst nach der Freigabe angek\xFCndigt
es wurde abgebrochen
die Steuerung l\xE4uft nicht; sie startet von selbst neu, siehe System
das Gateway beobachtet nur; erlaube ihm Befehle unter System, Ger\xE4te
homebot l\xE4uft zur Probe und sendet nichts
au\xDFer Betrieb
es braucht einen Code
ein anderes Ger\xE4t wird gerade verbunden
der Code ist falsch; wenn du dir sicher bist, versuche es noch einmal
es ist schon anderswo verbunden; entferne es dort oder setze es zur\xFCck
zu viele falsche Codes; nimm es kurz vom Strom
nach einem falschen Code braucht es eine Pause; versuche es sp\xE4ter
mit diesem Code wurde kein Ger\xE4t gefunden; ist es bereit zum Verbinden, in diesem Netz und noch nirgends verbunden?
ein Matter-Code hat 11 oder 21 Ziffern oder ist ein QR-Code, der mit MT: beginnt
homebot kann hier nicht selbst neu starten; starte es neu
es gibt nichts zur\xFCckzunehmen, oder die Datei wurde seitdem ge\xE4ndert
Befehle
abgelehnte Anfragen
getrennte Clients
verworfene Teile
verlorene R\xFCckmeldungen
verlorene Nachrichten
abgelehnte Verbindungen
gescheiterte Verbindungen
verworfen (QoS 0)
verworfen f\xFCr Abwesende
verworfen, weil zu langsam gelesen
verworfen, weil zu gro\xDF
abgelehnte Nachrichten
abgelehnte Abonnements
nicht aufbewahrte Nachrichten
gescheiterte Anmeldungen
Fehler des Journals
Fehler der Ger\xE4teliste
verworfene Mitteilungen
gescheiterte Mitteilungen
gek\xFCrzte Kennungen
verlorene Zust\xE4nde
verpasste Neuigkeiten
abgelehnte Ank\xFCndigungen
homebot place GER\xC4T RAUM
Titel
Interpret
Sicherungsschalter
der Broker
dort antwortet kein Programm: starte es, oder berichtige die Adresse
kein Weg zu diesem Rechner
keine Antwort
der Name des Rechners ist unbekannt: berichtige die Adresse
noch nicht verbunden
nicht verbunden
die Verbindung wurde beendet
die Verbindung ging verloren
der Broker antwortet nicht mehr
das Ger\xE4t hat diesen Teil nicht mehr
das widerspricht sich; gib nur eines an
der Code ist falsch
es hat keines
dieses Ger\xE4t gibt es nicht
es macht das Haus sicherer
er hat keinen Bewegungsmelder
die Ger\xE4te des Hauses sind noch nicht bekannt
es geh\xF6rt nicht zu dem, was der Zugang steuern darf
niemand hat es erfahren; [notify] und das Log sagen, warum
es gibt keine Adresse: in [notify] steht keine
einer seiner Werte ist unbekannt
noch wurde nichts ge\xE4ndert
es steht in der Konfiguration; \xE4ndere dort [places]
HomeKit hat daf\xFCr keinen Dienst
von selbst
von Hand
durch ein anderes Programm
von Hand oder von selbst
der Raum des Ger\xE4ts ist unbekannt, also ist vielleicht jemand dort
es tr\xE4gt das Kennzeichen always_ask
es schaltet den Alarm unscharf
Gilt ab jetzt.
Home Assistant lehnt es ab, oder der Code ist falsch
es hat sich seit deiner Freigabe ver\xE4ndert
es hat sich seitdem ver\xE4ndert; sieh es noch einmal an
sein Modus ist unbekannt; stelle ihn zuerst ein
der Thermostat ist in einem anderen Modus; \xE4ndere ihn zuerst
sein anderer Sollwert ist unbekannt, und beide geh\xF6ren zusammen
in diesem Modus gibt es diesen Sollwert nicht
das Ger\xE4t l\xE4sst sich nur ausschalten, wie ein Herd zur Sicherheit
es ist kein JPEG, PNG, GIF oder WebP bis 2 MiB
das Token gilt nicht mehr, oder f\xFCr etwas anderes`,n=`gateway {name} is away: {reason}
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
