var n=`12j 1nt xg kp 7jj e9 1ca 7b 6gn o4 1jy 16u 187 3l 43 1ys dl 2gl 9k l 16l dy 1tl mb 18g 1 2g jv ht 1ey b2g 2o9 57v 56 77i 19j 2ce eq 2dy f9 2u5 25s 6sh 2u 34u ds 6z 8u 1ck 15z dw fw tk 9a 3z9 dz 2d 2re 1sy 26q 4il 5th 9s 28y f4 fs 2do afh 8f 3i5 cv 61l 2hu 1 yw 2so 21l qk 1pk f8 49v h0 2nv 50y 1ws 50y 2qv sp qi 1p8 16f qf cf sm 8r ds 1m5 fv 6a 4pw 2p6 143 1bj 2ur 1px 3lz cz 18x 1x9 3eg 2dx 7on 1cp 3c 34y 11h 169 eh df da 8ls 1q9 x4 3xe 14o c7w 3ah 5z 5k 32g s0 l7 9fy 1xr 44j 27j ta g3 ep qk 6mh 12p 1og 1xv 15x 49 el 23l 328 5i 100 327 1wm 1xk 1ap 2t4 2v1 5x 2k 4s 2h8 1kc 2g6 2i9 2no r4 6rc 1v6 1q0 i9 32t 1av 42x xs 13 kd 112 3bm 1n4 1e2 b2 p6 1i3 wv 1w6 3qg 175 3jk g7 41r 2g7 3il 1pz 2g1 ro 3wh 1qt 26e oz 3rr 1tg 1c f3 6yx al 4so 17l 41w 6dv 1kc 1nd cu 1rj 7fv 59c 140 1be 3cm dw 4go 1li zh 4yb 68y c2 5d0 31 2er 3sa 43i 1kz 34i 4w8 13r 22m ak9 2ou 1q1 6gs 2nw v4 hm 3in ay dx 54a 8ph 8yp 1n2 226 5j4 3kr 8p c9 1ax 4x xt 2z1 2b9 1lj 7q3 8ma 7vl cel 24 5el xa mf 3wt 3xk 2qm 6vi hx 6bj 6o 4on byf 4ut t9 2h 405 2ht 1x7 1pt 1eb 4zo 6rz 9yz 53o a8 ow 1cc 3gv 3ej 7a 3r 226 ub 9jc 1v 2cw 8b p9 17l 149 13y 59b 2bs 3pw 1sj 5ho 1ho 17t 8mb fn 2jv rf c0p 2s 14d hy 2nz 1gt r4 1qs 31i 2z9 klp 18a 207 tj tg 3q 3g 2bl ji c 2s9 4x6 6xf 11b 14h 2e8 emi 2tj cz yw 1tn aa 34y 4ut 2y0 1y 2tz gr 2ny 60j 3jv 1nb th 1ew 5jo 7z 1pz 6mz 2pe 2mr tx 1ce 7d7 44g 1w8 x 2fx 11r a9 2m1 4ci 133 9l 72c 6i vc 5um nr 2dc 483 pv 3s 7gs e5 308 l6 447 ui 23k 233 1fi ca lq 2ct vi 23l bq 1ds z0 d6 31k 3ca 4i2 k2 4sq 2g3 1vq 3oz 2a8 26q 341 1r9 28q 344 3d0 1lc 28 13 3je oz z7 206 2gi cj x9 8u 4k5 2pp 7t 37h 3kx rh 2nq 84j 1cx 1bw 4sv 3y 4dy ox 1jt 1dk 1d0 1h 46 4ig r7 392 132 3ok 27c 33y 7j 3ql z4 1tg bg 303 11 28r 1tv 3e 976 6e4 40v bmc 1xq zn 5sd 4so 3u 5lg 38 4j1 3tr 13q 350 8xl 15c 1o8 18z 4m3 af jf 3yp 2vr 2q3 sw 176 7y f 2f4 14r 18b 27i 1q7 56i 2k2 38y 5g3 2s9 lu 1xh xr we 4f6 1ox r 179 ed6 18o 1lc 9r 1 2nd bd 59v 3yl 3zn o 13q 23e ij 9xx gb qp bu to 2ub a1g 11h 1b4 1p3 1cl 40g 1f3 7n3 32e zz ha 1sv 3h6 1pm 2gp 1kl 3qy 1f2 3qi 2d3 23v 5ta 5p 31l 2qw 9nh 5n 39d 28q 16x 3fr 58u 1e3 aa 2c 1h 38r y ep 5tz 3it pv q4 tn k3 18d akw 1ki 1kq 5on is 1nx 16s 19d 3f 2hr 3fi 5up 2zs 2m7 82 3pd 20r 3x7 6f 3lr 5j1 w3 171 kp h 1nr 8ry 16b 17q 42u vd 3po 11x z 26y 9x0 5jo l2 24d 4aw bm 6y 4et 125 35n 1ta 71r 1c5 2y 2f b8 27u 113 4rf 4f5 958 2el 1n7 2d4 32f 7wy 73a 1l1 3ly 4dj 8jf 4n fb 1ua 18k xh
non ha risposto in tempo
Garage
Giardino
segnala manomissione
configurazione errata
gateway
rilevatore di perdite
Sette giorni
Aggiungi
il robot ha un ordine; metti prima la sua opzione su idle
homebot gira in prova e non invia nulla
Registro
PM1
la tabella di un gateway ha segreti, nessuna pagina la legge
Comandi
Perch\xE9
il broker non risponde pi\xF9
esci
richiesta
errori del file dei dispositivi
ultime volte
se parte mentre \xE8 in corso
bassa
adesso
eseguita
grezzo
rendila tua, o indicane un'altra in HOMEBOT_DATA
tag
C'\xE8 un incendio? Uscite e chiamate i vigili del fuoco
ha segnalato {values}
raggiunto con
se homebot \xE8 gi\xE0 in funzione, chiediglielo: homebot doctor
nessun percorso verso quel computer
when: che cosa la avvia, una riga ciascuno
preimpostazione
nessun programma risponde l\xEC: avvialo, o correggi l'indirizzo
annulla
umidit\xE0 del terreno
indietro
prima
uno dei suoi valori \xE8 sconosciuto
sensore di pioggia
\xE8 scattato
ne vuole pi\xF9 d'uno insieme, e non si pu\xF2
Oggi
da >
asciuga
normale
Token
la stanza del dispositivo
Argomento
ritardo del ciclo degli eventi
Lingua
Serve: $
rapporti
annunci rifiutati
batteria scarica
reinstalla l'homebot pi\xF9 recente, o: homebot restore BACKUP
I nuovi gateway iniziano al prossimo avvio di homebot.
aspirapolvere che non sono ancora robot
\xE8 occupato
crea un backup
usa #
{issuer} ha pubblicato {text}
un bridge non ha codice: premi il suo pulsante
sostituiscila o caricala
la stanza del dispositivo \xE8 sconosciuta, quindi forse c'\xE8 qualcuno
fumo o calore
danne uno, come level 40
Lo dice un messaggio conservato, ma non da quando.
In vigore da ora.
Persone
nascondi
alta
ha l'etichetta always_ask
lo stato della casa
in ritardo di
accetta una data senza fuso orario
\xC8 cos\xEC da quando homebot lo conosce.
rilevatore di gelo
la rete lo ha accettato
Longitudine
da solo
Un token d\xE0 a questa pagina i suoi diritti: il tuo \xE8 la riga in owner.token, nella cartella dei dati di homebot. Per un tablet creane uno con:
famiglia
Caricamento della pianta \u2026
robot
Esclusi perch\xE9 segreti: {files}
annunci rifiutati
Come ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com li elenca tutti.
, da un altro programma
niente vi \xE8 stato unito
errori del diario
da un altro programma
connessioni fallite
produttore
scartati, troppo lunghi
homebot why DISPOSITIVO mostra le segnalazioni
Terrazza
accetta numeri da 0 a 360, da 0 a 100
homebot sa chi \xE8 in casa dai telefoni nella rete e dai tracker.
> fa
ore di silenzio
da {least} a {most}
Conserva i valori attuali di:
modalit\xE0
\xE8 bagnato
annunci
accetta true o false
modalit\xE0 ventola
prossima volta
La casa \xE8 aperta
mostra che cosa permette l'approvazione di #
if: tutto ci\xF2 che deve valere allora
climatizzatore
non \xE8 stato inviato
da {issuer}
Ora in homebot.toml c'\xE8:
Nome e luogo
I nodi a sinistra pubblicano argomenti, quelli a destra vi si abbonano.
il nome del computer \xE8 sconosciuto: correggi l'indirizzo
accessi falliti
fermo
Piano terra
topic rifiutati
piano
usa una directory su questo computer, o configura il suo indirizzo
Cronologia
ogni volta
sensore di apertura
indirizzi rifiutati
chiudilo
accetta una data dal 1970 al 2106
\xE8 nella configurazione; cambia [places] l\xEC
modalit\xE0
non connesso
Telefono nella rete
anidride carbonica
nascondilo nella casa
Aprite le finestre, uscite e chiamate aiuto
accetta solo true
ha appena annunciato altri topic per i comandi, forse di un altro dispositivo; riprova
Questo schermo
{nodes} nodi e {topics} argomenti
Indirizzo
temperatura del colore
tipi rifiutati
localizzatore
le lamelle si aprono (100) e si chiudono (0) soltanto
$ nel tempo, * punti
composti organici volatili
non disponibile
la sua memoria \xE8 piena
visto l'ultima volta
questa modalit\xE0 non ha quel valore
copiato
associa
annunci: byte di troppo
non c'\xE8 nulla da annullare, o il file \xE8 cambiato da allora
ricreato
non fare nulla
il suo modello non d\xE0 nulla per questo
non ha un sensore di movimento
homebot cerca nella cronologia di quattro settimane ci\xF2 che fai di continuo, e lo osserva una settimana prima di proporlo.
homebot show DISPOSITIVO
non ha ancora segnalato nulla dall'avvio di homebot
gli abbinamenti con Apple Home
Niente fiamme n\xE9 interruttori; aprite le finestre, uscite e chiamate aiuto
nuova routine
tapparella o tenda
Non ci sono ancora serrature, contatti o allarmi.
pianta con * stanze
un numero
Fuso orario
Ogni schermo ha un proprio token, che pu\xF2 essere revocato.
I suoi dispositivi compaiono qui.
quarantene
non ne accetta
pressione
impostazione
in funzione
Questa immagine non \xE8 pi\xF9 recente.
Un server su questo computer
Un dispositivo senza valore viene tolto.
aspetta, al massimo un minuto, i dispositivi di prima; riprova
conservalo in questo browser
non ha un ordine da proseguire; dagli una destinazione
dispositivi rifiutati
lasciare che questa routine comandi {names}
sensore di qualit\xE0 dell'aria
Le tue abitudini
la connessione a Home Assistant \xE8 caduta
Allarmi e domande arrivano con questi indirizzi a telefoni, chat e posta.
non ne ha annunciate
il dispositivo risponde con un errore
il robot non ha ancora detto il suo stato
messaggi al secondo
l'indirizzo di un flusso, come una radio
pulsante
Il suo ultimo evento, che non \xE8 uno stato:
comandi falliti
Di recente qui
salvato
rilevatore di fumo o CO
sensore di flusso
annunci: byte in memoria
intensit\xE0 del segnale
avanti
trova
homebot qui non pu\xF2 riavviarsi da solo; riavvialo
Fumo, acqua, movimento
un numero finito
modello
nessun indirizzo
valori rifiutati
Non \xE8 ancora successo nulla.
risposte
pi\xF9 nomi per un identificatore: forse pi\xF9 dispositivi
{issuer} ha chiesto {values}
La custodia \xE8 aperta, o \xE8 staccato dal muro?
la connessione \xE8 stata chiusa
il suo bridge non lo raggiunge
tosaerba
\xC8 cambiato alle >.
rilevatore
il dispositivo trasmette soltanto
Non capito alle >:
interruttore magnetotermico
sensore di luce
Premi il pulsante del dispositivo, poi \xABassocia\xBB.
il registro e homebot journal dicono di pi\xF9
dai a homebot una cartella in cui scrivere (HOMEBOT_DATA), o avvialo con --ephemeral
sensore di umidit\xE0
inviato in un solo messaggio al gruppo #
tutto
sensore di pressione
App
Home Assistant ha chiuso la connessione
Nessun dispositivo indica ancora potenza o energia.
client interrotti
non ancora connesso
valvola dell'acqua
dopo un codice sbagliato vuole una pausa; riprova pi\xF9 tardi
bluetoothd non \xE8 in esecuzione
non noto: {names}
nessuno \xE8 stato avvisato; [notify] e il log dicono perch\xE9
aggiornamento
Va tutto bene.
Dopo cinque minuti mostra un orologio tenue e ci\xF2 che \xE8 aperto. L'indirizzo di questo schermo:
inviato in un solo messaggio alla scena #
scaldabagno
presenza
riavvia #
rifiuta
annulla
velocit\xE0
centrale d'allarme
contatore elettrico
Che cosa si sa, e da dove
un'altra chiave
Studio
Senza contatore proprio
nessun comando manda a casa le persone
indica password_file o password_env in [gateways.mdns.drivers.shelly]
grafo
Non c'\xE8 nulla da proporre.
Non c'\xE8 (pi\xF9) un dispositivo #.
frequenza
il dispositivo non ha pi\xF9 questa parte
# \xE8 associato.
Riscalda con una finestra aperta
Cambiato dalla precedente approvazione:
do: i suoi passi, una riga ciascuno
non \xE8 un bridge Hue; abbina il bridge a cui appartiene
iscrizioni rifiutate
invia ci\xF2 che il suo annuncio non spiega
ultima versione
{energy} immessi
dove si trova questo schermo
quando
il gateway osserva soltanto; permettigli i comandi in Sistema, Dispositivi
Senza TLS il browser non installa l'app: tls = true in [door].
homebot gira senza file; avvialo in una cartella con homebot.toml
Di quel periodo non \xE8 conservato nulla.
serratura
crea un token
non l'hai fatto
Caricamento delle routine \u2026
HomeKit non ha un servizio per questo
topic riservati
avanzamento dell'aggiornamento
non \xE8 ancora cambiato nulla
dai la chiave che la sua configurazione ESPHome ha sotto "api: encryption:" come key_file, o nessuna
In attesa della tua approvazione
nessuna risposta
Backup
Il codice sul dispositivo
Mostra
nessuna scena ne conserva uno
Home Assistant lo rifiuta, o il codice \xE8 sbagliato
nomina un dispositivo, o cerca come 'light in hall'
fai
Allarmi
richieste rifiutate
lettore video
ricevuti
Nessuna stanza ha ancora una forma. Dalle degli angoli nella tabella [places.rooms], o importa una mappa: homebot places import FILE.
dai a ogni dispositivo un identificatore suo negli annunci; intanto le sue parti hanno questi nomi
il codice \xE8 sbagliato
ricerca \u2026
non accetta comandi; segnala soltanto
una scena ha valori che durano; per ci\xF2 che si fa una volta usa una routine
innocuo
non c'\xE8 D-Bus; su Linux, bluetoothd e il bus di sistema devono essere in esecuzione
ogni passo
contraddizione
risposte sconosciute
non c'\xE8 una via per i comandi
utente
troppi codici sbagliati; scollegalo un momento
porta
Energia per giorno
orari e la casa
trovati, e non ancora usati
Nessuna app \xE8 in corso.
inviato di nuovo
il suo modello fallisce con questo codice
Caricamento del grafo \u2026
messaggi persi
ricomincia
non si pu\xF2 osservare
un programma sconosciuto
Dispositivi
file di dati
soprattutto #
frequenza
modifica
on o off
risponde solo una persona, sulla pagina
il dispositivo \xE8 in servizio, ma i suoi attributi non si sono potuti leggere
si sta gi\xE0 associando un altro dispositivo
nessun dispositivo trovato con questo codice; \xE8 pronto per l'associazione, in questa rete e non gi\xE0 associato?
annunci derivati
si contraddicono; danne uno solo
homebot show DEVICE mostra entrambi i lati; homebot forget DEVICE lo chiude
Ingresso
contenuti
chiudi l'acqua
\xE8 irraggiungibile
il dispositivo si pu\xF2 solo spegnere, come un piano cottura per sicurezza
nessuna via per quella rete
un'altra password
le ultime 24 ore
Interrogo homebot \u2026
Non \xE8 ancora contato nulla.
\xE8 silenzioso da troppo tempo
troppo lunghi
\xE8 stato annullato
sensore di temperatura
ha la batteria scarica
il controllo non \xE8 in funzione; si riavvia da solo, vedi Sistema
batteria, corrente, portata?
rifiutati
Colori
pulire stanze
accetta una data con fuso orario
\xE8 cambiato nel frattempo; guardalo di nuovo
solo un'app o una routine pu\xF2 averne uno, con la sua chiave \`act\`
non arrivano pi\xF9 eventi
energia del {day}
annunci ignorati
il termostato \xE8 in un'altra modalit\xE0; cambiala prima
Nome
True o False
non raggiungibile
la sua convenzione \xE8 fallita
non qui
Latitudine
oscillazione
l'hai fatto > dopo
\xC8 in corso \u2026
homebot place DISPOSITIVO STANZA
Diagnosi
cerca abitudini
Codice QR
Adesso
permesso
senza dare un motivo
correggerla, poi: homebot config check
batteria in carica
riavvia homebot dopo una nuova tabella: docs/protocols.md
alla casa
Porte e finestre
Ricevitore pi\xF9 lento
Code e perdite
il server Matter \xE8 stato spento
Era cos\xEC alla prima segnalazione.
questa domanda non c'\xE8 pi\xF9; \`homebot answer\` elenca quelle aperte
osserva: #
aggiungi la tabella e riavvia homebot: docs/robots.md
segnala fumo o calore
, da solo
Persona
conserva
tutti a casa
Nessun dispositivo indica ancora una temperatura.
una password
Etichette
notifiche fallite
Argomenti pi\xF9 attivi
perdita d'acqua
dopo
il server Matter \xE8 troppo lento
la directory non \xE8 ancora stata letta
attendi un minuto, poi guarda il registro di homebot
scadenze scartate
notifiche scartate
scartati, malformati
Messaggi
il robot non sa dov'\xE8; localizzalo prima
un'altra cifratura
sensore
una nuova stanza
il client #
dall'avvio di questo gateway non ha detto che cosa sa fare; forse dorme: sveglialo, e riprova
ci ha messo troppo
Contiene tutto ci\xF2 che homebot conserva, tranne le password.
preferito
a riposo
immagine
trasgressori dimenticati
manomissione
# pu\xF2 comandare i dispositivi
proposta da #
approvazione
stati persi
Schermi
Nella settimana di prova l'hai fatto {done} volte su {total}; una routine farebbe bene dal {low} al {high} % delle volte.
accetta pi\xF9 di 0 e fino a 100 %
aperto da molto
l'altro suo valore \xE8 ignoto, e i due vanno insieme
, dal dispositivo o da una persona
diritti
attivit\xE0
, un'eco
, da una persona
non \xE8 un JPEG, PNG, GIF o WebP fino a 2 MiB
messaggi in attesa e persi
non se ne sa nulla che una scena possa ripristinare
il suo gateway codifica i suoi messaggi
cambiato in {values}
esegui ora
Un punto pieno \xE8 acceso, aperto od occupato.
il broker
\xE8 cambiato da quando lo hai approvato
modalit\xE0
in attesa
imposta
monossido di carbonio
identificatori tagliati
umidificatore
la sua modalit\xE0 \xE8 ignota; impostala prima
La casa \xE8 chiusa
Va tutto bene. Da notare:
una sola password andrebbe in chiaro a chi si chiama cos\xEC: aggiungi "api: encryption:" alla sua configurazione ESPHome e dai key_file, o il suo indirizzo IP fisso come allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
una pressione del suo pulsante
robot aspirapolvere
\xE8 aperto
riscontri persi
questo homebot non conserva nulla
A una parete
ora non noto
Nascosti
nessun annuncio valido dall'avvio di questo gateway; riavvia il dispositivo o il suo bridge, o aspetta
Il luogo d\xE0 alba e tramonto; resta qui.
Apri questo una volta sullo schermo; viene mostrato solo ora:
I primi valori arrivano tra due secondi.
continua senza token
il codice \xE8 sbagliato; se ne sei sicuro, riprova
since deve precedere until
segreto
non c'\xE8 un indirizzo: [notify] non ne ha
Token o codice
Ogni dispositivo ha una stanza.
inizia con {view}
Routine pronte
\`homebot find\` mostra ci\xF2 che va bene
Ci\xF2 che cambi qui si vede su ogni schermo.
Il codice mostrato da homebot run fa entrare il primo schermo.
flusso
CoAP non ha questo metodo
Pu\xF2
conteso
, perch\xE9 {device} ha segnalato {values}
segnala monossido di carbonio
annunci ambigui
libreria mancante
il testo
annunci rinviati
connessione
non si pu\xF2 codificare come UTF-8
Nell\u2019app Casa: +, Aggiungi accessorio, e scansiona questo o scrivi il codice.
correggi o togli il mittente
questo protocollo non accetta comandi grezzi; usa un indirizzo testuale
routine pronte
errori
Abbinato a * controller.
tinta (0 a 360) e saturazione (0 a 100), come 0,100 per rosso o 240,50 per azzurro
Nulla di misurato \xE8 in funzione.
invio \u2026
come il sistema
i tag non accettano comandi
novit\xE0 perse
connessioni rifiutate
\u2026 e altri *
\xE8 associato altrove; rimuovilo l\xEC o ripristinalo
perdita d'acqua
ascensore
, in corso
guardare
persi
dalle il diritto
Nome, stanza ed etichette
Utente
valori
il profilo del dispositivo non ha un frame per questo
Nessuna delle * voci pi\xF9 recenti ha queste parole.
un testo
Camera
Ci\xF2 che conserva questa scena non ne dice i valori.
fuori da tutte le stanze
\xE8 stato annunciato dopo l'approvazione del dispositivo
temperatura ambiente
Non c'\xE8 ancora nessuna routine.
interblocco
Bagno
risposte tardive
chiedere sempre
richieste scartate
se
Le righe appaiono qui man mano.
sensore di presenza
non ha indirizzo
questo homebot non ha routine
risolvi come dice il registro: homebot app reload APP, homebot gateway restart NAME
non ne ha
chiaro
a mano o da solo
# \xE8 stato scaricato ({size} kB).
, perch\xE9 \xE8 stata annullata la scena {scene}
messaggi non conservati
Cucina
oscillazione orizzontale
Non ha ancora segnalato cambiamenti.
Chi la usa adesso
il proprietario non l'ha approvato
Ciclo degli eventi
Valori, cronologia, dati
Valori
guardare e agire
la connessione \xE8 andata persa
scartati, troppi
la cifratura
cartella dei dati
richiede un codice
accetta stanze, ma non ne ha ancora nominate
energia immessa
il broker integrato non pu\xF2 ascoltare: tutte le porte sono occupate
disinserisce l'allarme
riscaldamento
Per ripristinarlo:
suono della sirena
ancora * s
titolo
Cantina
i dispositivi della casa non sono ancora noti
, perch\xE9 \xE8 stata applicata la scena {scene}
stanza
rimuovi #
fuori casa
rifiuta la password di password_file o password_env in [gateways.mdns.drivers.shelly]
sensore del terreno
attivo
rende la casa pi\xF9 sicura
a mano
non \xE8 tra ci\xF2 che l'accesso pu\xF2 comandare
prendi i valori attuali
scartati, lettura troppo lenta
correggi il dispositivo o il suo annuncio
servono secondi, 0 o pi\xF9
le pi\xF9 recenti prima
Trovati:
qualit\xE0 dell'aria
un codice Matter ha 11 o 21 cifre, o \xE8 un codice QR che inizia con MT:
lo storico non \xE8 iniziato, o non viene conservato; \`homebot doctor\` dice perch\xE9
batteria, corrente, portata? Se non c'\xE8 pi\xF9: homebot forget DEVICE
, a causa di $
solo la tabella di un gateway accetta password o token
accetta un numero che il suo formato pu\xF2 esprimere
pu\xF2 comandare
Il messaggio di prova \xE8 stato inviato.
l'hai fatto > prima
PM10
Il certificato di cui i tuoi dispositivi devono fidarsi
lettore di tag
quel dispositivo non esiste
Non c'\xE8 ancora nessun dispositivo.
il server Matter non ha Bluetooth; raggiunge solo dispositivi in rete
pianta con * stanza
{issuer} \xE8 stato rifiutato: &
il bridge risponde qualcosa di sconosciuto
Soggiorno
{energy} kWh in altri giorni simili
accetta
Altri comandi
il registro ha ognuno con la sua traccia: segnalalo o correggilo
Password
scuro
approva #
scartati per assenti
reindirizza a un altro computer, e non viene seguito
insieme
accedi
scartati (QoS 0)
comandi
il suo effetto non dura
riavvia homebot
segnala gas
Premi ora il pulsante: ancora * s
niente
artista
la porta \xE8 forse aperta
si fa una volta e non dura
non \xE8 un proxy Bluetooth; aggiungi "bluetooth_proxy:" alla sua configurazione ESPHome
senza stanza
scartati, troppo grandi
comandi rifiutati
versione
L'approvazione permette questi comandi:
tu, con $
messaggi rifiutati
valori illeggibili
immagine di #
invia un messaggio di prova
reindirizza troppo spesso
segnala un problema
Nessun dispositivo di questa casa \xE8 adatto: $
scrittura \u2026
il token non vale pi\xF9, o \xE8 di un altro
servono due dispositivi diversi
salva
inviato
mostra`,o=`# asks, so another answers: use the owner's token, and give programs their own
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
# chiede, quindi risponde un altro: usa il token del proprietario, e dai ai programmi il loro
# deve chiedere da s\xE9
la domanda \xE8 chiusa: &
il server Matter risponde con l'errore *
il bridge per HomeKit non pu\xF2 ascoltare su #, porta *: &
non \xE8 ancora associato; $, con il codice stampato sopra
non ha la parte #; ha $
< non scende mai sotto {least}, e non ha interruttore
vuole <; &
accetta percento; intendevi < %? Per $ %: #
accetta un testo della forma $ (*)
un numero in $
di $? < \xE8 sconosciuto; dai un valore, come #
non ha stanza: $
# \xE8 stato commutato * volte in {span} s
# \xE8 stato commutato * volte in {span} s; con un token (\`homebot token new\`) un programma pu\xF2 di pi\xF9
un riavvio lo perderebbe, perch\xE9 non \xE8 stato scritto: &
# \xE8 in uso da un homebot attivo
# \xE8 nella configurazione; cambia l\xEC [places]
contiene dispositivi: $; mettili prima altrove
nessun comando l'ha dato a #, che ha <
nessun comando ha detto la stanza di #
non c'\xE8 il dispositivo #, e nessun comando ha detto la sua stanza
possono essere * con {most} parti in tutto; togline prima una
troppe prove: aspetta * s
approvalo con \`homebot approve ^\`, e {advice}
se non pu\xF2 nuocere a nessuno, \`homebot tag add ^ #\`, altrimenti {advice}
la proposta * non c'\xE8 pi\xF9; \`homebot suggest\` li elenca
# non \xE8 innocuo (&), ed \xE8 cambiato dalla tua approvazione: $; approvalo con \`homebot approve ^\`
^ # non \xE8 aperto
metti ci\xF2 che la sua configurazione ESPHome ha sotto "api: encryption: key:" in un file, e nominalo in [gateways.mdns.drivers.esphome.devices."^"] come key_file
metti ci\xF2 che la sua configurazione ESPHome ha sotto "api: password:" in un file, e nominalo in [gateways.mdns.drivers.esphome.devices."^"] come password_file
aggiungi "api: encryption:" alla sua configurazione ESPHome, o togli la chiave in [gateways.mdns.drivers.esphome.devices."^"]
si annuncia a <, ma allow_plaintext_at \xE8 $; &
qualcuno deve acconsentire: &
non si sa se # \xE8 acceso; di' on o off
nessun dispositivo corrisponde a #; &
volevi dire #?
niente vicino a # si pu\xF2 comandare; escluso: $
non finch\xE9 {condition}: < \xE8 sconosciuto
accetta un testo della forma $
accetta $ secondo ISO 8601
un comando ne ha da 1 a *
serve un testo di al massimo * caratteri
ce ne sono gi\xE0 *; ritirane qualcuna
nessuna importazione lo indica; &
ci sono gi\xE0 * decisioni; annullane qualcuna
non ha l'annuncio #; ha $
&; \`at_night\` (\`--night\`) lo permette
ora qualcuno dorme in ~
nulla \xE8 cambiato, perch\xE9 i valori di prima non si possono conservare: &
non c'\xE8 un dispositivo o un'immagine #
nessuna connessione in * s
non ha la caratteristica #
nessun dispositivo \xE8 raggiungibile: &
un altro proxy ha il suo indirizzo #
l'interfaccia # non va per il multicast <: &
^ # non si pu\xF2 aprire: &
^ # non pu\xF2 essere <: &
nessun endpoint CoAP si pu\xF2 aprire: &
niente multicast < sull'interfaccia #: &
mDNS non si pu\xF2 usare su #: &
$ di [#] vale per l'indirizzo attuale; indicalo di nuovo con quello nuovo
$ di [#] nomina un segreto di questo computer; solo una persona lo scrive nel file
supera i * caratteri
il broker integrato non pu\xF2 ascoltare: la porta * \xE8 occupata
non ha annunciato # come argomento di comando
il broker integrato non pu\xF2 ascoltare: &
vuole $, ed \xE8 configurato #
vuole $, e non si pu\xF2
non cifra; &
accetta un testo da {least} a {most} caratteri
accetta un testo di al massimo * caratteri
accetta un testo di al massimo $
il suo modello fallisce: $
il suo modello $
non si pu\xF2 codificare come $
Home Assistant non si \xE8 presentato in * s
scalderebbe a {least} \xB0C e raffredderebbe a {most} \xB0C
stato HAP *
il bridge di # non \xE8 connesso
il nodo * \xE8 in funzione, ma il gateway ha gi\xE0 max_nodes
il gateway Matter non ha il dispositivo #
il dispositivo risponde con lo stato $
il dispositivo risponde con l'errore $
l'indirizzo # \xE8 sconosciuto: &
il tipo di contenuto # non si capisce
l'osservazione di # \xE8 finita
in # non si possono fare copie: &
accetta &, e nessuna variazione
non offre $
non ha lo script #; una tabella [[gateways.ble.proxies]] lo installa
il robot non accetta ordini nel modo $
una pagina non pu\xF2 cambiare la tabella #, solo: $
la chiave # carica un programma o un file; scrivila tu
non puoi dare il diritto #; usa: homebot token new
nessun backup ha un byte *; comincia da 0
la modifica # non nomina nulla
l'indirizzo # non \xE8 pi\xF9 nel file; guardalo di nuovo
il gateway # si riavvia
il gateway # \xE8 assente: &
# non ha risposto entro * s; non si sa se l'ha fatto
rifiutato (<): &
tornato dopo * s, <
non inviato: &
contraddetto: &
ora il nome del computer non si pu\xF2 risolvere ($)
# ha l'ascensore
< ha chiuso la connessione
# non \xE8 connesso: &
# non \xE8 connesso
# non ha risposto entro * s
# dorme; riprova quando \xE8 sveglio
# non \xE8 disponibile in Home Assistant
Home Assistant non ha pi\xF9 un'entit\xE0 per #
# non ha un driver; \`homebot doctor\` elenca gli inutilizzabili
il certificato di # non \xE8 attendibile
$: il server risponde *, forse funzioner\xE0 pi\xF9 tardi
il server risponde *
chiede una password (stato *)
non lascia entrare homebot con quella password (stato *)
non accetta: <
accetta un numero da {least} a {most}
non ha questa impostazione; accetta {list}
# non ha misurato cambiamenti
non c'\xE8 un dispositivo #
non c'\xE8 nessuno in ~
# non ha mai rilevato nessuno; passaci davanti una volta
# si sente solo da * s
&, e l'accesso permette solo $; aggiungi {right} nella tabella [{table}] di homebot.toml
&, e l'accesso permette solo $
un dispositivo cos\xEC richiede un diritto che lo nomini (&)
$, e questo prevale ancora per * s
<, secondo un vecchio messaggio: ora irraggiungibile
<, secondo un vecchio messaggio: visto {age} fa
<, secondo un messaggio conservato: non si \xE8 ancora fatto sentire
# ora si chiama $
# \xE8 rifiutato e non torner\xE0
# non \xE8 in funzione: &
esiste gi\xE0 una routine o app #; scegli un altro nome, o modifica quella
# \xE8 nella configurazione; cambialo l\xEC, e poi: $
niente da annullare: # non \xE8 stata applicata, o \xE8 gi\xE0 annullata
di # non resta nulla da ripristinare
la scena # esiste gi\xE0
# non \xE8 in casa ora; lascialo cos\xEC, o toglilo
possono essere *; prima togline uno
# \xE8 cambiato nel frattempo; guardalo, e riprova
# esiste gi\xE0; rimuovilo, o dai un altro nome al gateway
&, perci\xF2 solo con il suo nome: $
non \xE8 abbinato: $
# non \xE8 abbinato a homebot
l'ultimo ricaricamento \xE8 stato rifiutato: &
nessuna risposta entro * s
troppi codici senza effetto noto da {issuer}
non mentre {condition}, e lo stato di # \xE8 sconosciuto: &
c'\xE8 qualcuno in ~: # era attivo * s fa, e da allora nessuna porta si \xE8 aperta
forse c'\xE8 qualcuno in ~: # \xE8 cambiato * s fa, e nessun comando lo spiega
# richiede un diritto che lo nomini (&), e {issuer} non ne ha; {advice}
# richiede un diritto, perch\xE9 &, e {issuer} non ne ha; {advice}
non \xE8 nell'elenco dei dispositivi innocui ($)
tenuto a < da {holder} fino al rilascio
tenuto a < da {holder} ancora per * s
tenuto da {holder} fino al rilascio: <
tenuto da {holder} ancora per * s: <
# ha detto no
nessuno ha risposto entro * s: si fa sulla pagina o con \`homebot answer\`
sono le >, e c'\xE8 silenzio dalle {start} alle {end}
il robot # \xE8 in viaggio in ~ o verso di esso
c'\xE8 qualcuno in ~: $
c'era qualcuno in ~ * s fa: $
forse c'\xE8 qualcuno in ~: $
non si sa se c'\xE8 qualcuno in ~: &
non mentre {condition}: $
il membro # rifiuta: &
{issuer} non pu\xF2 comandare #, solo: $
{issuer} non pu\xF2 comandare #: &
nessun dispositivo \xE8 raggiungibile: &
# non \xE8 raggiungibile: &
# non \xE8 in rete ora
la connessione a # \xE8 stata persa
tipo: <
tipo: <
si chiama #
la sua unit\xE0 \xE8 #
scalda fino a * \xB0C
accanto a un'altra parte: &
il nome # dice $
il modello # dice $
il gateway # non dice il suo stato
problema di #
abbandonato da #
errori in # dall'avvio
contato da # negli ultimi dieci minuti
contato da # dall'avvio
in quarantena presso #, che legge solo una parte dei loro messaggi
nota su #
gateway #: <, invia comandi
gateway #: <, osserva soltanto: &
gateway #: <, osserva soltanto
si \xE8 bloccato ({error}) e riparte tra >; subito: {text}
gateway #: <: &
& Dopo il riavvio di homebot: {keys}
Il file \xE8 rimasto com'era: &
* dispositivi attendono l'approvazione e prima non ricevono nulla: {list}
1 dispositivo attende l'approvazione e prima non riceve nulla: {list}
l'ultimo messaggio non \xE8 stato inviato: &
visto {age} fa
fatto: $
saltata: non $
$ non riuscito: &
< (* %)
<, da {age}
# non \xE8 sicuro (&), e <; approvalo con \`homebot approve ^\`
la regola \xE8 fallita: $
* comandi attendono il loro esito
il suo gateway # \xE8 <: &
il suo gateway # \xE8 <
# non ha risposto entro * s: $
nessuno ascolta $
il suo pulsante non \xE8 stato premuto entro * s; premilo e riprova
# non \xE8 stato associato: &
$ \xE8 stato rifiutato: &
# non ha immagini
^: # non ha visto effetti del suo ultimo comando; dopo la riparazione, \`homebot trust $\`
accetta: &
questa parte accetta: {list}
nessuna delle sue modalit\xE0: {list}
il dispositivo risponde: &
# \xE8 gi\xE0 associato a homebot
# dipende dal bridge $, che si associa per intero
&; riprova tra * s
da qui, solo: <
la stanza # esiste gi\xE0
# si chiama gi\xE0 cos\xEC
# \xE8 associato a un altro sistema; rimuovilo l\xEC o reimpostalo, poi $
# \xE8 rimosso
# \xE8 modificato
# \xE8 aggiunto
# ha detto s\xEC
# non risponde
# non ha risposto
# non accetta comandi che homebot conosce
* dispositivi corrispondono a #; al massimo {most} alla volta
$ non \xE8 stato inviato a #: &
$ \xE8 stato inviato a #: &
$ di #: &
# ha gi\xE0 $
# non ha parti
# non \xE8 raggiungibile con TLS: &
* proxy Bluetooth sono gi\xE0 connessi
# impiega pi\xF9 di * s per una risposta
# non \xE8 noto ad alcun endpoint
# non ha un indirizzo HTTP
# non ha indirizzo
# non risponde alle richieste
# non accetta messaggi
# ha interrotto gli eventi
# non si pu\xF2 annunciare come $: &
#: * comandi aspettano gi\xE0 $
# non si pu\xF2 aprire: &
# non \xE8 stato impostato: &
# si abbina con il codice che riporta: $
# \xE8 gi\xE0 in funzione
# \xE8 dietro il bridge $ (^); si pu\xF2 rimuovere solo il bridge
# non risponde al server Matter
# non si \xE8 ancora descritto
$ di # non si pu\xF2 impostare
# non si pu\xF2 scrivere: &
# non si pu\xF2 mettere da parte: &
# non si pu\xF2 copiare: &
# di $ non pu\xF2 avere un file proprio
# = $ non \xE8 un valore TOML; i testi vogliono le virgolette
# non pu\xF2 essere un nome: dai fino a * caratteri stampabili
# non funziona ($): &
sono le >, e si dorme dalle {start} alle {end}
\`$ --act ^\` ne d\xE0 uno
$ act = [^] ne d\xE0 uno
# a $: &
$ a passi di *
$ secondi o pi\xF9
da {least} a {most} s
# (&)
non c'\xE8 < #; &`;export{o as reasons,n as texts};
