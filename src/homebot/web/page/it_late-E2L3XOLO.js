var n=`QWV4JaIQK9CW2gIMyVD5PUtxIb6TuAveluAFTcXoKXCJIxrqr9sHHDpMoFHjhl8bpPpBxAImqhvBHOrk4b8g1qsJV8Ysvss4tcyYlTGTnd4tPVUddUuAh1anjf33KtCeUr4Y4PQWV4lZMoF1kX6WyjpNrln0zf9Q4uuqkJ1HZSXWhzzpd7GmSCh77HDUWkYjQ4SNZmEEgrFMzE9MNWq8qlVoV6aCWmna9ijPWWT8GWBeFigZU4czRA5yvuhl1VrGHfxNwSeVLs2Nb9gTzFkiNxH8624eVPCyIHMXWYw7wpR7TtTGTDc5LPBKpv7KGuS48AptDpwHBd1iGmbLuuDYjypCQJkokBEIRnk1YrckIA8pqOeXyK06g0BbEG2allKfL7EOlGcORRKC6mdUugMFY681XZaONNjo3creUTStsHzDxJ4TgzYJcbP4l4Wk7dnpqdCh2gSztbU4vCK7cpCDxEevL1h3xZnqdEbUgKIFbYQPKqgRyZpsILru0InWclQBvRRHFcVqjwI7y7jqOZCqH8C9HvStl3xlxyLQpab218SKFO09Zzjl24mVXZTgijn5vWLVLgw8tfKlMMNHEb0ykgYNsMqvHYrD9D0qbw44nldeyXkxH6aE6tL62S94BbpIeotv5EePwHgGUl3x2iYyH2MLSgR3fAi8ppG3B4pRzqjcZqCsQ5tqw8MMUwXjnlQPvgNNU33EeRYayp67H7hrFEdNBZFk4PmQnOsxH20o7dSbzldkr3QKILwjqlSrmBIzoNRplcNkGoWzRoio2L8adl8M9ejP8rqnsmNqyyXaOF0BDDYQeK56fUYtakrYiu03xszCBJS6Bj80D4wwaDKx8sqHipBVXIkzGCEtdsC4UQq2DH4PXBjI00jaQZnemc55FrKxMCxhMqzwoUoy3PMpTgNpvFCmHLJ7BuJi2ZVAPRXL7Ycm2YdN0kcvvv0LTveMaSQyIcWNUY9jZrhxm6Kh2RpJq0jLWVw1MnMrBU2ksDHMIIynPOfuSsnicykS9j9tVqz3VP3VW8ZYxq1gkBuLihaPHEUAqXfO7Yr2iehTczOSXVINJjqZ1cVNm8D3uDt3pmpNZnWOKNfJbefR1FfmS33s3aRSWGnQ9MnScNI27AJJIywxb0tM3eW3DlaGfBXHZj40BgHY8Sa5uDPJpv6qPdMsHwCuybQxMW36oXVJF7OKKA4MLsEREMs224X23WjGZGSY9RHL5vVbCAzWXCIowM0TV5Z7x8eqM5Vm7oZiE9GWTMBXdwBitAfspkKaTFskYkTyawnGxIVIwJC0KuxB1cxQOWV1ypKED31GqpVsIoLWAiZtMmzdsB95HTpb8BlmSz9bNq3ghQdY0wu8AwLZanF2YdmN55gvnRTxK2rOdydZaMBruUkkKOxyRjcduej8QuslOfD8MQOGus7SjsoTzAz3Ms7UPa7dxvdcQElpQ5VpCI3e28yVog39M5H3Z1tkTmRr8eI2jISkILbbbRJzwLER8skqJGOmAhhemOYccKV3VNiOu8LMFq0jP3v6vmEoR95m1IWskukneTLeO4lYoZzBeghDuLZc6qrbHrYOceCkRP1KtFffjnMeYpkXkZZRGXCg78F0rELfKNK1YJPQiu7hkRecEe1KXFyWxOELCyRZYf2MVAMQo5NEdZzS0gywRe3m36FexdhkeRFmwmBTrC
Ci\xF2 che cambi qui si vede su ogni schermo.
annulla
prima
non qui
nascondi
Nascosti
accedi
esci
A una parete
inizia con {view}
a riposo
Dopo cinque minuti mostra un orologio tenue e ci\xF2 che \xE8 aperto. L'indirizzo di questo schermo:
Senza TLS il browser non installa l'app: tls = true in [door].
Il certificato di cui i tuoi dispositivi devono fidarsi
Lingua
Un token d\xE0 a questa pagina i suoi diritti: il tuo \xE8 la riga in owner.token, nella cartella dei dati di homebot. Per un tablet creane uno con:
Token
conservalo in questo browser
continua senza token
imposta
da {least} a {most}
Nome
Etichette
Nome, stanza ed etichette
una nuova stanza
nascondilo nella casa
salva
salvato
Non c'\xE8 nessun dispositivo in una stanza {room}.
Senza contatore proprio
Non c'\xE8 (pi\xF9) un dispositivo {name}.
Valori
da {time}
Comandi
Perch\xE9
Il suo ultimo evento, che non \xE8 uno stato:
Non ha ancora segnalato cambiamenti.
\xC8 cos\xEC da quando homebot lo conosce.
Lo dice un messaggio conservato, ma non da quando.
Era cos\xEC alla prima segnalazione.
\xC8 cambiato alle {time}.
Che cosa si sa, e da dove
Non capito alle {time}:
visto l'ultima volta
{time} fa
tu, con {what}
raggiunto con
contraddizione
Cronologia
Di quel periodo non \xE8 conservato nulla.
Energia per giorno
{energy} immessi
energia del {day}
Caricamento della pianta \u2026
Nessuna stanza ha ancora una forma. Dalle degli angoli nella tabella [places.rooms], o importa una mappa: homebot places import FILE.
Piano terra
pianta con {count} stanza
pianta con {count} stanze
Un punto pieno \xE8 acceso, aperto od occupato.
fuori da tutte le stanze
ora non noto
Caricamento delle routine \u2026
Non c'\xE8 ancora nessuna routine.
nuova routine
proposta da {name}
prossima volta
ultime volte
esegui ora
dalle il diritto
lasciare che questa routine comandi {names}
pu\xF2 comandare
, perch\xE9 \xE8 stata applicata la scena {scene}
, perch\xE9 \xE8 stata annullata la scena {scene}
inviato in un solo messaggio al gruppo {name}
inviato in un solo messaggio alla scena {name}
Un dispositivo senza valore viene tolto.
Conserva i valori attuali di:
Non c'\xE8 nulla da proporre.
Ci\xF2 che conserva questa scena non ne dice i valori.
Le tue abitudini
accetta
rifiuta
conserva
ogni volta
homebot cerca nella cronologia di quattro settimane ci\xF2 che fai di continuo, e lo osserva una settimana prima di proporlo.
osserva: {name}
cerca abitudini
ricerca \u2026
rimuovi {name}
prendi i valori attuali
l'hai fatto {time} dopo
l'hai fatto {time} prima
non l'hai fatto
Nella settimana di prova l'hai fatto {done} volte su {total}; una routine farebbe bene dal {low} al {high} % delle volte.
when: che cosa la avvia, una riga ciascuno
if: tutto ci\xF2 che deve valere allora
do: i suoi passi, una riga ciascuno
se parte mentre \xE8 in corso
il testo
ogni passo
Nessuna delle {count} voci pi\xF9 recenti ha queste parole.
Non \xE8 ancora successo nulla.
le pi\xF9 recenti prima
il client {name}
un programma sconosciuto
{issuer} ha chiesto {values}
inviato
inviato di nuovo
la rete lo ha accettato
ha segnalato {values}
cambiato in {values}
{issuer} ha pubblicato {text}
{issuer} \xE8 stato rifiutato: {reason}
da {issuer}
, perch\xE9 {device} ha segnalato {values}
, a causa di {what}
, in corso
, un'eco
, da solo
, da una persona
, da un altro programma
, dal dispositivo o da una persona
permesso
gateway
Interrogo homebot \u2026
Diagnosi
Va tutto bene.
Va tutto bene. Da notare:
\u2026 e altri {count}
App
Nessuna app \xE8 in corso.
Non \xE8 ancora contato nulla.
Registro
Le righe appaiono qui man mano.
In attesa della tua approvazione
mostra che cosa permette l'approvazione di {name}
mostra
L'approvazione permette questi comandi:
Cambiato dalla precedente approvazione:
approva {name}
Caricamento del grafo \u2026
Mostra
tutto
I nodi a sinistra pubblicano argomenti, quelli a destra vi si abbonano.
grafo
{nodes} nodi e {topics} argomenti
I primi valori arrivano tra due secondi.
Messaggi
{what} nel tempo, {count} punti
messaggi al secondo
Code e perdite
messaggi in attesa e persi
in attesa
persi
Ciclo degli eventi
ritardo del ciclo degli eventi
in ritardo di
Argomenti pi\xF9 attivi
Argomento
Ricevitore pi\xF9 lento
stanza
adesso
robot
tag
fuori casa
in funzione
scelta
umidit\xE0
PM2,5
Colori
come il sistema
chiaro
scuro
Questo schermo
tutto acceso
Porte e finestre
Porte, sensori e altro
Fumo, acqua, movimento
preferito
Riscalda con una finestra aperta
Di recente
Di recente qui
Altri comandi
Nessun dispositivo indica ancora una temperatura.
Nessun dispositivo indica ancora potenza o energia.
Nulla di misurato \xE8 in funzione.
Adesso
Oggi
Sette giorni
Chi la usa adesso
soprattutto {name}
{energy} kWh in altri giorni simili
La casa \xE8 aperta
La casa \xE8 chiusa
Non ci sono ancora serrature, contatti o allarmi.
Non c'\xE8 immagine.
Questa immagine non \xE8 pi\xF9 recente.
Valori, cronologia, dati
pulsanti, impostazioni e aggiornamenti: {count}
non noto: {names}
le ultime 24 ore
Configurazione
Nome e luogo
Dispositivi
Schermi
scrittura \u2026
Ora in homebot.toml c'\xE8:
annulla
avanti
alla casa
Fuso orario
Latitudine
Longitudine
Il luogo d\xE0 alba e tramonto; resta qui.
dove si trova questo schermo
Un server su questo computer
usa {name}
{name} pu\xF2 comandare i dispositivi
Aggiungi
Indirizzo
Utente
Password
I nuovi gateway iniziano al prossimo avvio di homebot.
riavvia homebot
Ogni dispositivo ha una stanza.
Non c'\xE8 ancora nessun dispositivo.
Ogni schermo ha un proprio token, che pu\xF2 essere revocato.
Pu\xF2
guardare
guardare e agire
tutto
crea un token
Apri questo una volta sullo schermo; viene mostrato solo ora:
Token o codice
Il codice mostrato da homebot run fa entrare il primo schermo.
Cucina
Soggiorno
Camera
Bagno
Ingresso
Studio
Giardino
Garage
Cantina
Terrazza
Routine pronte
routine pronte
Nessun dispositivo di questa casa \xE8 adatto: {what}
indietro
riscaldamento
Persone
Allarmi
Backup
Persona
Telefono nella rete
modifica
invio \u2026
associa
homebot sa chi \xE8 in casa dai telefoni nella rete e dai tracker.
Allarmi e domande arrivano con questi indirizzi a telefoni, chat e posta.
Il messaggio di prova \xE8 stato inviato.
invia un messaggio di prova
Come ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com li elenca tutti.
Contiene tutto ci\xF2 che homebot conserva, tranne le password.
crea un backup
\xC8 in corso \u2026
{name} \xE8 stato scaricato ({size} kB).
Per ripristinarlo:
Esclusi perch\xE9 segreti: {files}
Il codice sul dispositivo
Premi il pulsante del dispositivo, poi \xABassocia\xBB.
ancora {count} s
Premi ora il pulsante: ancora {count} s
{name} \xE8 associato.
Trovati:
I suoi dispositivi compaiono qui.
fumo o calore
perdita d'acqua
manomissione
aperto da molto
batteria scarica
C'\xE8 un incendio? Uscite e chiamate i vigili del fuoco
Aprite le finestre, uscite e chiamate aiuto
Niente fiamme n\xE9 interruttori; aprite le finestre, uscite e chiamate aiuto
chiudi l'acqua
chiudilo
La custodia \xE8 aperta, o \xE8 staccato dal muro?
batteria, corrente, portata?
sostituiscila o caricala
homebot show DISPOSITIVO
homebot why DISPOSITIVO mostra le segnalazioni
quando
se
fai
non fare nulla
ricomincia
dopo
insieme
diritti
richiesta
chiedere sempre
approvazione
innocuo
presenza
ore di silenzio
frequenza
interblocco
produttore
modello
serratura
tapparella o tenda
climatizzatore
valvola dell'acqua
robot aspirapolvere
scaldabagno
umidificatore
tosaerba
centrale d'allarme
sensore di apertura
sensore di presenza
rilevatore di fumo o CO
rilevatore di perdite
sensore di pioggia
rilevatore di gelo
sensore di qualit\xE0 dell'aria
sensore del terreno
sensore di temperatura
sensore di umidit\xE0
sensore di luce
sensore di pressione
sensore di flusso
pulsante
contatore elettrico
lettore video
famiglia
localizzatore
lettore di tag
sensore
rilevatore
impostazione
aggiornamento
tutti a casa
asciuga
temperatura del colore
velocit\xE0
temperatura impostata
temperatura di raffreddamento
temperatura ambiente
modalit\xE0
attivit\xE0
preimpostazione
oscillazione
oscillazione orizzontale
modalit\xE0 ventola
umidit\xE0 impostata
modalit\xE0
modalit\xE0
suono della sirena
trova
grezzo
versione
ultima versione
immagine
perdita d'acqua
connessione
batteria in carica
pressione
flusso
energia immessa
frequenza
anidride carbonica
monossido di carbonio
PM10
PM1
composti organici volatili
qualit\xE0 dell'aria
umidit\xE0 del terreno
intensit\xE0 del segnale
immagine di {name}
umido da
campanello
luminosit\xE0
ora di dormire
congelatore
limite
dopo
ora
mattina
sera
aperto da
abbassato
contatore
per
movimento
buio sotto
inizia
finisce
pianta
altra
dentro
caldo da
giorni
resta
freddo sotto
Una ventola gira finch\xE9 il bagno \xE8 umido.
Un pulsante comanda una lampada.
Subito un avviso se si apre una porta e nessuno \xE8 in casa.
Una suonata \xE8 segnalata, e al buio illumina l'ingresso.
Una lampada \xE8 accesa dal tramonto all'ora di dormire se c'\xE8 qualcuno.
Un avviso quando un congelatore \xE8 troppo caldo per un po'.
Un avviso quando il garage resta aperto, e di nuovo finch\xE9 lo \xE8.
Una pressione a letto: tutte le luci spente, e un avviso se qualcosa \xE8 aperto.
Pi\xF9 fresco se nessuno \xE8 in casa, caldo con il primo che arriva.
Pi\xF9 fresco di notte.
Caldo la mattina e la sera.
Un riscaldamento riposa finch\xE9 la sua finestra \xE8 aperta.
Un avviso quando la lavatrice ha finito.
Tutte le luci si spengono quando tutti sono usciti.
Luce finch\xE9 qualcuno si muove ed \xE8 buio; una lampada gi\xE0 accesa, o che qualcuno comanda intanto, resta com'\xE8.
Una luce tenue per il cammino di notte.
Un avviso quando una pianta ha bisogno d'acqua.
Un avviso quando si usa molta potenza per un po'.
Di sera lampade si accendono e spengono se nessuno \xE8 in casa.
Gi\xF9 di due terzi finch\xE9 fa caldo.
Gi\xF9 al tramonto, su la mattina.
Una presa si spegne di notte se il suo apparecchio aspetta soltanto.
L'aspirapolvere pulisce una volta al giorno quando tutti sono usciti.
Una lampada si schiarisce per venti minuti prima che ti alzi.
Luce e un avviso quando c'\xE8 acqua dove non deve.
Luce nel corridoio quando la porta si apre al buio.
Un avviso quando una finestra resta aperta e fuori fa freddo.
configurazione errata
correggerla, poi: homebot config check
libreria mancante
cartella dei dati
rendila tua, o indicane un'altra in HOMEBOT_DATA
file di dati
reinstalla l'homebot pi\xF9 recente, o: homebot restore BACKUP
porta
se homebot \xE8 gi\xE0 in funzione, chiediglielo: homebot doctor
non raggiungibile
attendi un minuto, poi guarda il registro di homebot
risolvi la causa nel registro, poi: homebot app reload APP, o riavvia homebot
batteria, corrente, portata? Se non c'\xE8 pi\xF9: homebot forget DEVICE
conteso
homebot show DEVICE mostra entrambi i lati; homebot forget DEVICE lo chiude
il registro ha ognuno con la sua traccia: segnalalo o correggilo
il registro e homebot journal dicono di pi\xF9
correggi o togli il mittente
invia ci\xF2 che il suo annuncio non spiega
correggi il dispositivo o il suo annuncio
segreto
pi\xF9 nomi per un identificatore: forse pi\xF9 dispositivi
dai a ogni dispositivo un identificatore suo negli annunci; intanto le sue parti hanno questi nomi
senza stanza
aspirapolvere che non sono ancora robot
aggiungi la tabella e riavvia homebot: docs/robots.md
trovati, e non ancora usati
riavvia homebot dopo una nuova tabella: docs/protocols.md
ricevuti
rifiutati
comandi rifiutati
comandi falliti
annunci
annunci ambigui
annunci rifiutati
annunci derivati
annunci rinviati
annunci ignorati
annunci: byte di troppo
annunci: byte in memoria
dispositivi rifiutati
topic rifiutati
topic riservati
tipi rifiutati
indirizzi rifiutati
rapporti
valori rifiutati
troppo lunghi
valori illeggibili
errori
richieste scartate
scadenze scartate
quarantene
trasgressori dimenticati
risposte
risposte tardive
risposte sconosciute
scartati, troppi
scartati, troppo lunghi
scartati, malformati
attivo
non disponibile
alta
bassa
normale
segnala fumo o calore
segnala monossido di carbonio
segnala gas
\xE8 bagnato
\xE8 scattato
segnala manomissione
segnala un problema
\xE8 aperto
ha la batteria scarica
eseguita
tenuto a {value} da {holder} fino al rilascio
tenuto a {value} da {holder} ancora per {count} s
tenuto da {holder} fino al rilascio: {value}
tenuto da {holder} ancora per {count} s: {value}
{name} ha detto no
nessuno ha risposto entro {count} s: si fa sulla pagina o con \`homebot answer\`
sono le {time}, e c'\xE8 silenzio dalle {start} alle {end}
c'\xE8 qualcuno in {room}: {what}
c'era qualcuno in {room} {count} s fa: {what}
forse c'\xE8 qualcuno in {room}: {what}
non si sa se c'\xE8 qualcuno in {room}: {what}
la stanza del dispositivo \xE8 sconosciuta, quindi forse c'\xE8 qualcuno
{name} \xE8 stato commutato {count} volte in {span} s
non mentre {condition}: {what}
il membro {name} rifiuta: {reason}
{issuer} non pu\xF2 comandare {name}, solo: {what}
{issuer} non pu\xF2 comandare {name}: {what}
nessun dispositivo \xE8 raggiungibile: {what}
{name} non \xE8 raggiungibile: {what}
{name} non \xE8 in rete ora
la connessione a {name} \xE8 stata persa
\xE8 un interruttore automatico
tipo: {value}
tipo: {value}
si chiama {name}
ha l'etichetta always_ask
disinserisce l'allarme
la sua unit\xE0 \xE8 {name}
scalda fino a {count} \xB0C
accanto a un'altra parte: {reason}
il nome {name} dice {what}
il modello {name} dice {what}
il gateway {name} non dice il suo stato
problema di {name}
abbandonato da {name}
errori in {name} dall'avvio
contato da {name} negli ultimi dieci minuti
contato da {name} dall'avvio
in quarantena presso {name}, che legge solo una parte dei loro messaggi
nota su {name}
gateway {name}: {value}, invia comandi
gateway {name}: {value}, osserva soltanto: {reason}
gateway {name}: {value}, osserva soltanto
gateway {name}: {value}: {reason}
{reason} Dopo il riavvio di homebot: {keys}
In vigore da ora.
Il file \xE8 rimasto com'era: {reason}
{count} dispositivi attendono l'approvazione e prima non ricevono nulla: {what}
1 dispositivo attende l'approvazione e prima non riceve nulla: {what}
l'ultimo messaggio non \xE8 stato inviato: {reason}
visto {age} fa
fatto: {what}
saltata: non {what}
{what} non riuscito: {reason}
{value} ({count} %)
{value}, da {age}`,a=["held at {value} by {holder} until it is released","held at {value} by {holder} for {count} s more","held {value} by {holder} until it is released","held {value} by {holder} for {count} s more","{name} said no","nobody answered within {count} s: a person does on the page, or with `homebot answer`","it is {time}, and quiet from {start} to {end}","somebody is in {room}: {what}","somebody was in {room} {count} s ago: {what}","somebody may be in {room}: {what}","it is unknown whether anybody is in {room}: {what}","the room of the device is unknown, so somebody may be there","{name} was switched back and forth {count} times within {span} s","not while {condition}: {what}","its member {name} is refused it: {reason}","{issuer} may not command {name}, only: {what}","{issuer} may not command {name}: {what}","no device can be reached: {what}","{name} cannot be reached: {what}","{name} is not on the network now","the connection to {name} was lost","it is a circuit breaker","it is a {value}","it is an {value}","it calls itself {name}","it has the tag always_ask","it disarms the alarm","its unit is {name}","it heats up to {count} \xB0C","beside another part: {reason}","the name {name} says {what}","the model {name} says {what}","gateway {name} does not report its state","problem of {name}","given up by {name}","failures in {name} since it started","counted by {name} in the last ten minutes","counted by {name} since it started","quarantined by {name}, which reads only some of their messages","note on {name}","gateway {name} is {value} and sends commands","gateway {name} is {value} and only observes: {reason}","gateway {name} is {value} and only observes","gateway {name} is {value}: {reason}","{reason}; restart homebot for the changes of {keys}","tokens, rights, policies and places were reloaded","the file is as it was: {reason}","{count} devices wait for approval, and nothing is sent before (`homebot approve DEVICE`): {what}","1 device waits for approval, and nothing is sent before (`homebot approve DEVICE`): {what}","the last notification was not sent: {reason}","last seen {age} ago","done: {what}","held back: not {what}","{what} failed: {reason}","{value} ({count} %)","{value}, for {age}"];export{a as reasons,n as texts};
