var n=`4w2yoNyHmVAl09JSb1NUOOirW8plFHRXtoNfHkuybiocTfoahynbfyP1GPQaNnRXZCvyxccMMyvPypvwg76kJp2QMy4SOPRECIhCpzXzfbx4T80oh8Zuu9YiPab6ybBLWagnQQfpzBOax2M8kz7jw8RDnvVACvROUyfaDvvrm3QJ48RzFkJQnR119wIOs8mtfKz045Jq8LKvOWOIPSPADpsKsnpVxtadOknuuLFl08uANUYifxMX57yxIVrRAgNjakuUPlXUJRz229N4h7YiSrl0ucJNAsLrF72Cy7TQOBodiB6wv9HbtJlBaY8WMk0dRFCV5wgN4LMOviw7mUsPfTjPSAnDM760XnVNoC1pLb2iNuk3JilUxTWUlKxgMtGnQMUwOMF4X4rnqr3K8uAXwt6oMchLyFuQmG2zxWv3TSozKzjfJJ20IkflBhAZAQMEonNJFALraLUVaBRQv7Pm17tJlbfXOgOYKIcca5aoUFqVYPLYzfJ9H7p100c7j5s0F6vSx7pVpsb8tyLBlYVsYZYdefNfeQJ5BDnOrdCuPG9tJAAa2PIky57Bpq6PNgqWfvADAPXkYaSp3VyzgubmDqTrJlSMApfmWMy35Dko0jQDW85dT9beSDrK0BN65ziwEBbuFBiSdpcMIVfHr6HQx8vMAacS0rDCuaL26wCylUAQ2PWpkIJYpBGu7qrDCIITmKuCUxpQVkhGFzHNxugHA8mehzaMmx49gB8hAXyZZyqsepVeDS7c2pPHzrrjQ1Tfnrz8X5lg8plp005MWaYBEoLcU9ezCgQZLI47Q3gKy9Iz7zeWgV97tgFTNtYz1rEaUoKT3JPvocErs8fC0Cpi0FAdXe6Qn4EuNu7fHnzKLioPIRIOQhvGVnAKufCzBt7eh8urvvu9TAhtlVMHTVJFYXrVlfMW9ShxcFmPP4lh8M7JW5K8Cz6IqozuA5ASXGKKJ1bvFTYKEHOYYBwzgCwfwbQb7HLWJNroAqvAttjuu6B3Qg7pHKPF9G37m50QyWmDlhql4zhwWl6NIrjSeE9dV7yTp5PaQSLmaY2iaExHUlJMcm6fMqU3X3xKoKtlbT8T2tnb69haSy8fr9fQTh0FPRxg3EnWIJYjeK3flG4EXUkBt5InRFBykHFGlrT2Wa4oX5v11QgBySOYEefEjmDKVm4ne1UldSlWYyLQ4F4JndG3tq0yHIWDEDTkWNZdqwdOB6NI034RE0eOA825ALtFLdVfuNROVdQKyYhtIGkM7YGrw7UATucq2PfSpUfwx2NLPDlsWbu0oTMLhhw3zqewGbamRhDn44uAxM1vBzE9NnMUuZNMAhb36mpYEumh6lyKXzeqs9fChC2Df0UI7WMkGz476UKewHsGHbrB91oWe6oetmWXtSMG7f4JUJDjQ0M3EDHWnjgDKdnBdMavDxB0RJEgHKOUMkq6mYTAtk37gXpzWZX6LvccJYBW7hxVYC5ZzCm4Wv0PdU2ikP3LuihkUd1Y2Y1rvoXNxxzeIVBVDY3ZFOjovy1eQbJDnildfmZpCOOzSyiqGPAiE6Iv549Uc0zMQn1kdr5E4BtLy0S1wSC1lHnPBOc9tMBTvw2ucf4oRBpIaMtghXUutHTUwYhQkd7ktG2j0qbN8NHnIc7udk3WY9kWWUJ4WTONgrnQ2ZSaHyuGCMWB3WMHk3VjXHf6LVEW8QLGbEweWRkqwMRw91VUByDy3zqCuIby2wKxezVIwZuTlY6KHNpbDQGDUdYTLMQFfAzaEzDmFmTb7xqKIM
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
Colori
come il sistema
chiaro
scuro
Questo schermo
Porte e finestre
Fumo, acqua, movimento
preferito
Riscalda con una finestra aperta
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
non noto: {names}
le ultime 24 ore
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
Nell\u2019app Casa: +, Aggiungi accessorio, e scansiona questo o scrivi il codice.
Abbinato a {count} controller.
gli abbinamenti con Apple Home
Codice QR
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
Serve: {what}
una pressione del suo pulsante
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
temperatura ambiente
modalit\xE0
attivit\xE0
preimpostazione
oscillazione
oscillazione orizzontale
modalit\xE0 ventola
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
non ha ancora segnalato nulla dall'avvio di homebot
\xE8 irraggiungibile
\xE8 silenzioso da troppo tempo
il proprietario non l'ha approvato
\xE8 stato annunciato dopo l'approvazione del dispositivo
\xE8 stato annullato
il controllo non \xE8 in funzione; si riavvia da solo, vedi Sistema
il gateway osserva soltanto; permettigli i comandi in Sistema, Dispositivi
homebot gira in prova e non invia nulla
fermo
richiede un codice
si sta gi\xE0 associando un altro dispositivo
il codice \xE8 sbagliato; se ne sei sicuro, riprova
\xE8 associato altrove; rimuovilo l\xEC o ripristinalo
troppi codici sbagliati; scollegalo un momento
dopo un codice sbagliato vuole una pausa; riprova pi\xF9 tardi
nessun dispositivo trovato con questo codice; \xE8 pronto per l'associazione, in questa rete e non gi\xE0 associato?
un codice Matter ha 11 o 21 cifre, o \xE8 un codice QR che inizia con MT:
homebot qui non pu\xF2 riavviarsi da solo; riavvialo
non c'\xE8 nulla da annullare, o il file \xE8 cambiato da allora
comandi
richieste rifiutate
client interrotti
frammenti scartati
riscontri persi
messaggi persi
connessioni rifiutate
connessioni fallite
scartati (QoS 0)
scartati per assenti
scartati, lettura troppo lenta
scartati, troppo grandi
messaggi rifiutati
iscrizioni rifiutate
messaggi non conservati
accessi falliti
errori del diario
errori del file dei dispositivi
notifiche scartate
notifiche fallite
identificatori tagliati
stati persi
novit\xE0 perse
annunci rifiutati
homebot place DISPOSITIVO STANZA
titolo
artista
interruttore magnetotermico
il broker
nessun programma risponde l\xEC: avvialo, o correggi l'indirizzo
nessun percorso verso quel computer
nessuna risposta
il nome del computer \xE8 sconosciuto: correggi l'indirizzo
non ancora connesso
non connesso
la connessione \xE8 stata chiusa
la connessione \xE8 andata persa
il broker non risponde pi\xF9
il dispositivo non ha pi\xF9 questa parte
si contraddicono; danne uno solo
il codice \xE8 sbagliato
non ne ha
quel dispositivo non esiste
rende la casa pi\xF9 sicura
non ha un sensore di movimento
i dispositivi della casa non sono ancora noti
non \xE8 tra ci\xF2 che l'accesso pu\xF2 comandare
nessuno \xE8 stato avvisato; [notify] e il log dicono perch\xE9
non c'\xE8 un indirizzo: [notify] non ne ha
uno dei suoi valori \xE8 sconosciuto
non \xE8 ancora cambiato nulla
\xE8 nella configurazione; cambia [places] l\xEC
HomeKit non ha un servizio per questo
da solo
a mano
da un altro programma
a mano o da solo
la stanza del dispositivo \xE8 sconosciuta, quindi forse c'\xE8 qualcuno
ha l'etichetta always_ask
disinserisce l'allarme
In vigore da ora.
Home Assistant lo rifiuta, o il codice \xE8 sbagliato
\xE8 cambiato da quando lo hai approvato
\xE8 cambiato nel frattempo; guardalo di nuovo
la sua modalit\xE0 \xE8 ignota; impostala prima
il termostato \xE8 in un'altra modalit\xE0; cambiala prima
l'altro suo valore \xE8 ignoto, e i due vanno insieme
questa modalit\xE0 non ha quel valore
il dispositivo si pu\xF2 solo spegnere, come un piano cottura per sicurezza
non \xE8 un JPEG, PNG, GIF o WebP fino a 2 MiB
il token non vale pi\xF9, o \xE8 di un altro`,a=`gateway {name} is away: {reason}
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
il gateway {name} \xE8 assente: {reason}
{name} non ha risposto entro {count} s; non si sa se l'ha fatto
rifiutato ({value}): {reason}
tornato dopo {count} s, {value}
non inviato: {reason}
contraddetto: {reason}
ora il nome del computer non si pu\xF2 risolvere ({what})
{value} ha chiuso la connessione
{name} non \xE8 connesso: {reason}
{name} non \xE8 connesso
{name} non ha risposto entro {count} s
{name} dorme; riprova quando \xE8 sveglio
{name} non \xE8 disponibile in Home Assistant
Home Assistant non ha pi\xF9 un'entit\xE0 per {name}
{name} non ha un driver; \`homebot doctor\` elenca gli inutilizzabili
il certificato di {name} non \xE8 attendibile
{what}: il server risponde {count}, forse funzioner\xE0 pi\xF9 tardi
il server risponde {count}
chiede una password (stato {count})
non lascia entrare homebot con quella password (stato {count})
non accetta: {value}
accetta un numero da {least} a {most}
non ha questa impostazione; accetta {list}
{name} non ha misurato cambiamenti
non c'\xE8 un dispositivo {name}
non c'\xE8 nessuno in {room}
{name} non ha mai rilevato nessuno; passaci davanti una volta
{name} si sente solo da {count} s
{reason}, e l'accesso permette solo {what}; aggiungi {right} nella tabella [{table}] di homebot.toml
{reason}, e l'accesso permette solo {what}
un dispositivo cos\xEC richiede un diritto che lo nomini ({reason})
{what}, e questo prevale ancora per {count} s
{value}, secondo un vecchio messaggio: ora irraggiungibile
{value}, secondo un vecchio messaggio: visto {age} fa
{value}, secondo un messaggio conservato: non si \xE8 ancora fatto sentire
{name} ora si chiama {what}
{name} \xE8 rifiutato e non torner\xE0
{name} non \xE8 in funzione: {reason}
esiste gi\xE0 una routine o app {name}; scegli un altro nome, o modifica quella
{name} \xE8 nella configurazione; cambialo l\xEC, e poi: {what}
niente da annullare: {name} non \xE8 stata applicata, o \xE8 gi\xE0 annullata
di {name} non resta nulla da ripristinare
la scena {name} esiste gi\xE0
{name} non \xE8 in casa ora; lascialo cos\xEC, o toglilo
possono essere {count}; prima togline uno
{name} \xE8 cambiato nel frattempo; guardalo, e riprova
{name} esiste gi\xE0; rimuovilo, o dai un altro nome al gateway
{reason}, perci\xF2 solo con il suo nome: {what}
non \xE8 abbinato: {what}
{name} non \xE8 abbinato a homebot
l'ultimo ricaricamento \xE8 stato rifiutato: {reason}
nessuna risposta entro {count} s
troppi codici senza effetto noto da {issuer}
non mentre {condition}, e lo stato di {name} \xE8 sconosciuto: {reason}
c'\xE8 qualcuno in {room}: {name} era attivo {count} s fa, e da allora nessuna porta si \xE8 aperta
forse c'\xE8 qualcuno in {room}: {name} \xE8 cambiato {count} s fa, e nessun comando lo spiega
{name} richiede un diritto che lo nomini ({reason}), e {issuer} non ne ha{what}
{name} richiede un diritto, perch\xE9 {reason}, e {issuer} non ne ha{what}
non \xE8 nell'elenco dei dispositivi innocui ({what})
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
non si sa se c'\xE8 qualcuno in {room}: {reason}
{name} \xE8 stato commutato {count} volte in {span} s
non mentre {condition}: {what}
il membro {name} rifiuta: {reason}
{issuer} non pu\xF2 comandare {name}, solo: {what}
{issuer} non pu\xF2 comandare {name}: {reason}
nessun dispositivo \xE8 raggiungibile: {reason}
{name} non \xE8 raggiungibile: {reason}
{name} non \xE8 in rete ora
la connessione a {name} \xE8 stata persa
tipo: {value}
tipo: {value}
si chiama {name}
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
Il file \xE8 rimasto com'era: {reason}
{count} dispositivi attendono l'approvazione e prima non ricevono nulla: {list}
1 dispositivo attende l'approvazione e prima non riceve nulla: {list}
l'ultimo messaggio non \xE8 stato inviato: {reason}
visto {age} fa
fatto: {what}
saltata: non {what}
{what} non riuscito: {reason}
{value} ({count} %)
{value}, da {age}
{name} non \xE8 sicuro ({reason}), e {value}; approvalo con {what}
la regola \xE8 fallita: {what}
{count} comandi attendono il loro esito
il suo gateway {name} \xE8 {value}: {reason}
il suo gateway {name} \xE8 {value}
{name} non ha risposto entro {count} s: {what}
nessuno ascolta {what}
il suo pulsante non \xE8 stato premuto entro {count} s; premilo e riprova
{name} non \xE8 stato associato: {reason}
{what} \xE8 stato rifiutato: {reason}
{name} non ha immagini
{id}: {name} non ha visto effetti del suo ultimo comando; dopo la riparazione, \`homebot trust {what}\`
{name} ({reason})
accetta: {what}
questa parte accetta: {list}
nessuna delle sue modalit\xE0: {list}
il dispositivo risponde: {what}
{name} \xE8 gi\xE0 associato a homebot
{name} dipende dal bridge {what}, che si associa per intero
{reason}; riprova tra {count} s
da qui, solo: {value}
la stanza {name} esiste gi\xE0
{name} si chiama gi\xE0 cos\xEC
{name} \xE8 associato a un altro sistema; rimuovilo l\xEC o reimpostalo, poi {what}
{name} \xE8 rimosso
{name} \xE8 modificato
{name} \xE8 aggiunto
{name} ha detto s\xEC
{name} non risponde
{name} non ha risposto`;export{a as reasons,n as texts};
