var n=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 2nx w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 21p 727 56y 5g 1sr 1 62v 1ir 1gj 61n nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 1zo 43 1z3 17l 6k kt f38 x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv d5u 1lo py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 32g 3b8 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 2hy 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu gyh ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 3ne 18n 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3j0 89 1qr el rb 1vc n5 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 811 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 2hh 18m 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 k9 1dh a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
pianta
il codice \xE8 sbagliato
ha l'etichetta always_ask
il testo
errori del diario
Garage
Giardino
stati persi
ricomincia
{name} \xE8 stato scaricato ({size} kB).
Non ha ancora segnalato cambiamenti.
sensore di flusso
il dispositivo trasmette soltanto
accedi
qualit\xE0 dell'aria
annunci rifiutati
risposte tardive
come il sistema
produttore
se homebot \xE8 gi\xE0 in funzione, chiediglielo: homebot doctor
conserva
file di dati
Aggiungi
accetta pi\xF9 di 0 e fino a 100 %
Terrazza
rapporti
Registro
PM1
client interrotti
anidride carbonica
In vigore da ora.
Perch\xE9
A una parete
Nessuna delle {count} voci pi\xF9 recenti ha queste parole.
oscillazione
Nella settimana di prova l'hai fatto {done} volte su {total}; una routine farebbe bene dal {low} al {high} % delle volte.
non ha ancora segnalato nulla dall'avvio di homebot
richiesta
artista
homebot show DEVICE mostra entrambi i lati; homebot forget DEVICE lo chiude
non ha un sensore di movimento
attivit\xE0
per
caldo da
Non ci sono ancora serrature, contatti o allarmi.
bassa
adesso
il server Matter non ha Bluetooth; raggiunge solo dispositivi in rete
eseguita
grezzo
tag
il suo gateway codifica i suoi messaggi
continua senza token
{issuer} ha chiesto {values}
lettore video
PM10
accetta un testo
l'hai fatto {time} prima
invio \u2026
Cronologia
gli abbinamenti con Apple Home
un programma sconosciuto
il server Matter \xE8 stato spento
dalle il diritto
nessuna scena ne conserva uno
un codice Matter ha 11 o 21 cifre, o \xE8 un codice QR che inizia con MT:
fai
\xE8 stato annullato
Che cosa si sa, e da dove
congelatore
la sua modalit\xE0 \xE8 ignota; impostala prima
porta
tipi rifiutati
troppo lunghi
fuori da tutte le stanze
scartati, lettura troppo lenta
\xE8 bagnato
l'altro suo valore \xE8 ignoto, e i due vanno insieme
risposte sconosciute
sensore di apertura
annunci rifiutati
Allarmi
aggiornamento
\xC8 in corso \u2026
\xC8 cambiato alle {time}.
da {issuer}
Una luce tenue per il cammino di notte.
preferito
batteria, corrente, portata?
Non capito alle {time}:
movimento
Diagnosi
non si pu\xF2 codificare come UTF-8
presenza
le ultime 24 ore
Un server su questo computer
titolo
nessuna porta TCP \xE8 libera per il broker integrato
il suo modello fallisce con questo codice
connessione
Una ventola gira finch\xE9 il bagno \xE8 umido.
riscontri persi
servono secondi, 0 o pi\xF9
riavvia homebot
Non c'\xE8 (pi\xF9) un dispositivo {name}.
a mano o da solo
homebot why DISPOSITIVO mostra le segnalazioni
homebot gira in prova e non invia nulla
il suo effetto non dura
il suo modello non d\xE0 nulla per questo
Utente
\xE8 cambiato nel frattempo; guardalo di nuovo
inviato in un solo messaggio al gruppo {name}
la connessione a Home Assistant \xE8 caduta
finisce
Comandi
contatore
notifiche scartate
annulla
segnala monossido di carbonio
rende la casa pi\xF9 sicura
ha segnalato {values}
\xE8 silenzioso da troppo tempo
approvazione
La custodia \xE8 aperta, o \xE8 staccato dal muro?
in attesa
dopo un codice sbagliato vuole una pausa; riprova pi\xF9 tardi
pianta con {count} stanza
nessun programma risponde l\xEC: avvialo, o correggi l'indirizzo
rilevatore di fumo o CO
rilevatore di gelo
non \xE8 un bridge Hue; abbina il bridge a cui appartiene
\xE8 cambiato da quando lo hai approvato
{what} nel tempo, {count} punti
Non \xE8 ancora successo nulla.
questo protocollo non accetta comandi grezzi; usa un indirizzo testuale
Luce finch\xE9 qualcuno si muove ed \xE8 buio; una lampada gi\xE0 accesa, o che qualcuno comanda intanto, resta com'\xE8.
Chi la usa adesso
non disponibile
Un token d\xE0 a questa pagina i suoi diritti: il tuo \xE8 la riga in owner.token, nella cartella dei dati di homebot. Per un tablet creane uno con:
Pi\xF9 fresco se nessuno \xE8 in casa, caldo con il primo che arriva.
, da una persona
Come ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com li elenca tutti.
la connessione \xE8 stata chiusa
accetta una data dal 1970 al 2106
non fare nulla
usa una directory su questo computer, o configura il suo indirizzo
la tabella di un gateway ha segreti, nessuna pagina la legge
impostazione
reinstalla l'homebot pi\xF9 recente, o: homebot restore BACKUP
Un avviso quando il garage resta aperto, e di nuovo finch\xE9 lo \xE8.
risolvi la causa nel registro, poi: homebot app reload APP, o riavvia homebot
climatizzatore
frammenti scartati
I nuovi gateway iniziano al prossimo avvio di homebot.
sensore di umidit\xE0
Allarmi e domande arrivano con questi indirizzi a telefoni, chat e posta.
il controllo non \xE8 in funzione; si riavvia da solo, vedi Sistema
comandi falliti
\u2026 e altri {count}
non arrivano pi\xF9 eventi
nessun dispositivo trovato con questo codice; \xE8 pronto per l'associazione, in questa rete e non gi\xE0 associato?
Abbinato a {count} controller.
permesso
accetta numeri da 0 a 360, da 0 a 100
usa {name}
In attesa della tua approvazione
manomissione
Persone
si contraddicono; danne uno solo
Aprite le finestre, uscite e chiamate aiuto
prima
, perch\xE9 \xE8 stata applicata la scena {scene}
salvato
, perch\xE9 \xE8 stata annullata la scena {scene}
da {time}
accetta solo true
il nome del computer \xE8 sconosciuto: correggi l'indirizzo
Latitudine
nascondilo nella casa
osserva: {name}
Le righe appaiono qui man mano.
inizia con {view}
Soggiorno
correggi o togli il mittente
accetta una data con fuso orario
Serve: {what}
i tag non accettano comandi
I suoi dispositivi compaiono qui.
Nessun dispositivo indica ancora una temperatura.
L'aspirapolvere pulisce una volta al giorno quando tutti sono usciti.
sensore di pioggia
Un riscaldamento riposa finch\xE9 la sua finestra \xE8 aperta.
non ne accetta
ultima versione
modello
if: tutto ci\xF2 che deve valere allora
messaggi persi
dentro
ora di dormire
messaggi non conservati
il client {name}
libreria mancante
umidit\xE0 del terreno
ogni passo
Questa immagine non \xE8 pi\xF9 recente.
annunci: byte in memoria
accetta on o off
quando
dopo
quarantene
sostituiscila o caricala
una nuova stanza
richieste rifiutate
Lo dice un messaggio conservato, ma non da quando.
pulsante
velocit\xE0
centrale d'allarme
aspirapolvere che non sono ancora robot
Non c'\xE8 ancora nessun dispositivo.
scaldabagno
Codice QR
Etichette
\xE8 irraggiungibile
umido da
buio sotto
giorni
immagine di {name}
utente
{energy} immessi
modifica
homebot gira senza file; avvialo in una cartella con homebot.toml
Ogni dispositivo ha una stanza.
ora
Camera
Adesso
visto l'ultima volta
limite
il broker non risponde pi\xF9
associa
richiede un codice
Backup
aggiungi la tabella e riavvia homebot: docs/robots.md
il dispositivo non ha pi\xF9 questa parte
Premi il pulsante del dispositivo, poi \xABassocia\xBB.
la connessione \xE8 andata persa
tosaerba
le pi\xF9 recenti prima
Ci\xF2 che conserva questa scena non ne dice i valori.
novit\xE0 perse
Nessun dispositivo di questa casa \xE8 adatto: {what}
avanti
trovati, e non ancora usati
grafo
non se ne sa nulla che una scena possa ripristinare
Questo schermo
Cantina
\xE8 associato altrove; rimuovilo l\xEC o ripristinalo
un bridge non ha codice: premi il suo pulsante
Pu\xF2
scartati per assenti
rifiutati
Gi\xF9 di due terzi finch\xE9 fa caldo.
da {least} a {most}
Un avviso quando una finestra resta aperta e fuori fa freddo.
Un avviso quando si usa molta potenza per un po'.
a riposo
una scena ha valori che durano; per ci\xF2 che si fa una volta usa una routine
Caricamento della pianta \u2026
chiudilo
modalit\xE0
Porte e finestre
raggiunto con
\xE8 nella configurazione; cambia [places] l\xEC
, a causa di {what}
Altri comandi
reindirizza troppo spesso
Nome, stanza ed etichette
immagine
Fuso orario
Interrogo homebot \u2026
gateway
umidificatore
Una pressione a letto: tutte le luci spente, e un avviso se qualcosa \xE8 aperto.
Non c'\xE8 ancora nessuna routine.
Telefono nella rete
frequenza
Niente fiamme n\xE9 interruttori; aprite le finestre, uscite e chiamate aiuto
Non c'\xE8 nulla da proporre.
nessuna risposta
indirizzi rifiutati
Argomenti pi\xF9 attivi
Nome
altra
Pi\xF9 fresco di notte.
Un avviso quando una pianta ha bisogno d'acqua.
nomina un dispositivo, o cerca come 'light in hall'
proposta da {name}
lettore di tag
prossima volta
annulla
segnala manomissione
Longitudine
Nome e luogo
suono della sirena
energia del {day}
Una presa si spegne di notte se il suo apparecchio aspetta soltanto.
Home Assistant lo rifiuta, o il codice \xE8 sbagliato
connessioni rifiutate
Routine pronte
{issuer} ha pubblicato {text}
sera
monossido di carbonio
Luce nel corridoio quando la porta si apre al buio.
sensore del terreno
Nessun dispositivo indica ancora potenza o energia.
ha la batteria scarica
scartati, troppo lunghi
se
scartati, malformati
Caldo la mattina e la sera.
temperatura del colore
Ogni schermo ha un proprio token, che pu\xF2 essere revocato.
messaggi in attesa e persi
reindirizza a un altro computer, e non viene seguito
richieste scartate
la directory non \xE8 ancora stata letta
Energia per giorno
\xE8 scattato
Piano terra
ore di silenzio
rendila tua, o indicane un'altra in HOMEBOT_DATA
when: che cosa la avvia, una riga ciascuno
pu\xF2 comandare
Mostra
Il codice sul dispositivo
errori del file dei dispositivi
annunci: byte di troppo
Un pulsante comanda una lampada.
salva
accetta true o false
Valori
inviato
annunci rinviati
freddo sotto
Le tue abitudini
segnala gas
mostra
Password
imposta
quel dispositivo non esiste
non ne ha
I primi valori arrivano tra due secondi.
perdita d'acqua
la sua descrizione non nomina il parametro
C'\xE8 un incendio? Uscite e chiamate i vigili del fuoco
annunci derivati
Una suonata \xE8 segnalata, e al buio illumina l'ingresso.
ultime volte
comandi
sensore di temperatura
la stanza del dispositivo \xE8 sconosciuta, quindi forse c'\xE8 qualcuno
Un dispositivo senza valore viene tolto.
La casa \xE8 chiusa
temperatura ambiente
attivo
robot
crea un token
soprattutto {name}
non noto: {names}
innocuo
chiudi l'acqua
il registro ha ognuno con la sua traccia: segnalalo o correggilo
nessun percorso verso quel computer
non \xE8 un proxy Bluetooth; aggiungi "bluetooth_proxy:" alla sua configurazione ESPHome
Bagno
il broker
Un avviso quando un congelatore \xE8 troppo caldo per un po'.
niente vi \xE8 stato unito
Nascosti
\xE8 aperto
Ora in homebot.toml c'\xE8:
non ha un ordine da proseguire; dagli una destinazione
Ciclo degli eventi
rilevatore
Ingresso
approva {name}
troppi codici sbagliati; scollegalo un momento
la porta \xE8 forse aperta
interblocco
Senza contatore proprio
Va tutto bene. Da notare:
Messaggi
Nessuna stanza ha ancora una forma. Dalle degli angoli nella tabella [places.rooms], o importa una mappa: homebot places import FILE.
inizia
segnala fumo o calore
contraddizione
nascondi
alta
\xE8 stato annunciato dopo l'approvazione del dispositivo
non l'hai fatto
non ne ha annunciate
esegui ora
Il codice mostrato da homebot run fa entrare il primo schermo.
energia immessa
accessi falliti
nessuno \xE8 stato avvisato; [notify] e il log dicono perch\xE9
solo la tabella di un gateway accetta password o token
Schermi
il robot ha un ordine; metti prima la sua opzione su idle
valori rifiutati
Era cos\xEC alla prima segnalazione.
Il messaggio di prova \xE8 stato inviato.
dove si trova questo schermo
chiedere sempre
annunci ignorati
, in corso
Valori, cronologia, dati
Conserva i valori attuali di:
Contiene tutto ci\xF2 che homebot conserva, tranne le password.
questa modalit\xE0 non ha quel valore
Un punto pieno \xE8 acceso, aperto od occupato.
Per ripristinarlo:
questo homebot non conserva nulla
homebot show DISPOSITIVO
cartella dei dati
servono due dispositivi diversi
Sette giorni
localizzatore
a mano
Home Assistant ha chiuso la connessione
il codice \xE8 sbagliato; se ne sei sicuro, riprova
identificatori tagliati
il gateway osserva soltanto; permettigli i comandi in Sistema, Dispositivi
La casa \xE8 aperta
non qui
Cambiato dalla precedente approvazione:
routine pronte
segnala un problema
non c'\xE8 nulla da annullare, o il file \xE8 cambiato da allora
ricerca \u2026
Il suo ultimo evento, che non \xE8 uno stato:
si fa una volta e non dura
alla casa
oscillazione orizzontale
Apri questo una volta sullo schermo; viene mostrato solo ora:
Il luogo d\xE0 alba e tramonto; resta qui.
il robot non ha ancora detto il suo stato
preimpostazione
disinserisce l'allarme
sensore
prendi i valori attuali
Una lampada \xE8 accesa dal tramonto all'ora di dormire se c'\xE8 qualcuno.
topic riservati
dispositivi rifiutati
{name} \xE8 associato.
riscaldamento
non connesso
resta
Persona
scartati (QoS 0)
luminosit\xE0
since deve precedere until
Nessuna app \xE8 in corso.
accetta una data senza fuso orario
Caricamento delle routine \u2026
attendi un minuto, poi guarda il registro di homebot
pi\xF9 nomi per un identificatore: forse pi\xF9 dispositivi
ne vuole pi\xF9 d'uno insieme, e non si pu\xF2
famiglia
piano
il dispositivo si pu\xF2 solo spegnere, come un piano cottura per sicurezza
non ancora connesso
il profilo del dispositivo non ha un frame per questo
L'approvazione permette questi comandi:
il token non vale pi\xF9, o \xE8 di un altro
da un altro programma
indietro
segreto
campanello
scrittura \u2026
I nodi a sinistra pubblicano argomenti, quelli a destra vi si abbonano.
, da solo
scadenze scartate
Ricevitore pi\xF9 lento
il termostato \xE8 in un'altra modalit\xE0; cambiala prima
, un'eco
l'hai fatto {time} dopo
accetta
HomeKit non ha un servizio per questo
Trovati:
non raggiungibile
Il certificato di cui i tuoi dispositivi devono fidarsi
correggerla, poi: homebot config check
intensit\xE0 del segnale
Dopo cinque minuti mostra un orologio tenue e ci\xF2 che \xE8 aperto. L'indirizzo di questo schermo:
\xC8 cos\xEC da quando homebot lo conosce.
non \xE8 stato inviato
contatore elettrico
fermo
tapparella o tenda
Caricamento del grafo \u2026
Token o codice
serratura
inviato in un solo messaggio alla scena {name}
, da un altro programma
non \xE8 ancora cambiato nulla
modalit\xE0 ventola
Va tutto bene.
accetta un numero che il suo formato pu\xF2 esprimere
Riscalda con una finestra aperta
non \xE8 un JPEG, PNG, GIF o WebP fino a 2 MiB
{time} fa
scartati, troppo grandi
correggi il dispositivo o il suo annuncio
modalit\xE0
tu, con {what}
se parte mentre \xE8 in corso
Dispositivi
Esclusi perch\xE9 segreti: {files}
invia un messaggio di prova
Non \xE8 ancora contato nulla.
homebot qui non pu\xF2 riavviarsi da solo; riavvialo
ritardo del ciclo degli eventi
il registro e homebot journal dicono di pi\xF9
riavvia homebot dopo una nuova tabella: docs/protocols.md
nuova routine
frequenza
trova
comandi rifiutati
il server Matter \xE8 troppo lento
dopo
in ritardo di
conteso
{name} pu\xF2 comandare i dispositivi
danne uno, come level 40
pressione
ogni volta
rilevatore di perdite
valvola dell'acqua
mattina
ricevuti
dai a ogni dispositivo un identificatore suo negli annunci; intanto le sue parti hanno questi nomi
tutti a casa
perdita d'acqua
aperto da molto
ascensore
sensore di presenza
topic rifiutati
nessun comando manda a casa le persone
guardare
persi
risposte
Premi ora il pulsante: ancora {count} s
CoAP non ha questo metodo
Di recente qui
do: i suoi passi, una riga ciascuno
pianta con {count} stanze
senza stanza
insieme
batteria in carica
Luce e un avviso quando c'\xE8 acqua dove non deve.
rimuovi {name}
sensore di pressione
crea un backup
non ha indirizzo
messaggi rifiutati
{nodes} nodi e {topics} argomenti
annunci ambigui
composti organici volatili
Di quel periodo non \xE8 conservato nulla.
guardare e agire
sensore di luce
diritti
App
batteria scarica
interruttore magnetotermico
Subito un avviso se si apre una porta e nessuno \xE8 in casa.
iscrizioni rifiutate
rifiuta
Oggi
cambiato in {values}
invia ci\xF2 che il suo annuncio non spiega
Token
stanza
{issuer} \xE8 stato rifiutato: {reason}
Argomento
homebot sa chi \xE8 in casa dai telefoni nella rete e dai tracker.
fuori casa
Di sera lampade si accendono e spengono se nessuno \xE8 in casa.
Un avviso quando la lavatrice ha finito.
la sua convenzione \xE8 fallita
abbassato
, dal dispositivo o da una persona
conservalo in questo browser
notifiche fallite
batteria, corrente, portata? Se non c'\xE8 pi\xF9: homebot forget DEVICE
asciuga
Studio
Code e perdite
Nulla di misurato \xE8 in funzione.
Ci\xF2 che cambi qui si vede su ogni schermo.
le lamelle si aprono (100) e si chiudono (0) soltanto
scartati, troppi
scuro
Senza TLS il browser non installa l'app: tls = true in [door].
versione
connessioni fallite
robot aspirapolvere
Colori
valori illeggibili
una pressione del suo pulsante
esci
da solo
ancora {count} s
non c'\xE8 un indirizzo: [notify] non ne ha
configurazione errata
Una lampada si schiarisce per venti minuti prima che ti alzi.
Non c'\xE8 immagine.
inviato di nuovo
mostra che cosa permette l'approvazione di {name}
homebot cerca nella cronologia di quattro settimane ci\xF2 che fai di continuo, e lo osserva una settimana prima di proporlo.
i dispositivi della casa non sono ancora noti
non si pu\xF2 osservare
Fumo, acqua, movimento
Cucina
Tutte le luci si spengono quando tutti sono usciti.
Indirizzo
il proprietario non l'ha approvato
flusso
fumo o calore
aperto da
, perch\xE9 {device} ha segnalato {values}
lasciare che questa routine comandi {names}
modalit\xE0
Lingua
Gi\xF9 al tramonto, su la mattina.
tutto
la rete lo ha accettato
cerca abitudini
non \xE8 tra ci\xF2 che l'accesso pu\xF2 comandare
{energy} kWh in altri giorni simili
normale
sensore di qualit\xE0 dell'aria
messaggi al secondo
in funzione
ora non noto
errori
chiaro
trasgressori dimenticati
uno dei suoi valori \xE8 sconosciuto
si sta gi\xE0 associando un altro dispositivo
Nell\u2019app Casa: +, Aggiungi accessorio, e scansiona questo o scrivi il codice.
homebot place DISPOSITIVO STANZA
annunci`,a=`a person must agree: {reason}
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
qualcuno deve acconsentire: {reason}
non si sa se {name} \xE8 acceso; di' on o off
nessun dispositivo corrisponde a {name}; {reason}
volevi dire {name}?
niente vicino a {name} si pu\xF2 comandare; escluso: {what}
non finch\xE9 {condition}: {name} \xE8 sconosciuto
accetta un testo della forma {what}
accetta {what} secondo ISO 8601
un comando ne ha da 1 a {count}
serve un testo di al massimo {count} caratteri
ce ne sono gi\xE0 {count}; ritirane qualcuna
nessuna importazione lo indica; {reason}
ci sono gi\xE0 {count} decisioni; annullane qualcuna
non ha l'annuncio {name}; ha {what}
il bridge per HomeKit non pu\xF2 ascoltare su {name}: {reason}
{reason}; \`at_night\` (\`--night\`) lo permette
ora qualcuno dorme in {room}
nulla \xE8 cambiato, perch\xE9 i valori di prima non si possono conservare: {reason}
non c'\xE8 un dispositivo o un'immagine {name}
nessuna connessione in {count} s
non ha la caratteristica {name}
nessun dispositivo \xE8 raggiungibile: {reason}
un altro proxy ha il suo indirizzo {name}
l'interfaccia {name} non va per il multicast {value}: {reason}
nessun endpoint CoAP si pu\xF2 aprire: {reason}
niente multicast {value} sull'interfaccia {name}: {reason}
mDNS non si pu\xF2 usare su {name}: {reason}
non ha annunciato {name} come argomento di comando
il broker integrato non pu\xF2 ascoltare: {reason}
vuole un'altra cifratura; {reason}
vuole {what}, ed \xE8 configurato {name}
vuole {what}, e non si pu\xF2
vuole la cifratura; {reason}
vuole un'altra password; {reason}
vuole {what}; {reason}
non cifra; {reason}
accetta un testo da {least} a {most} caratteri
accetta un testo di al massimo {count} caratteri
accetta un testo di al massimo {what}
il suo modello fallisce: {what}
il suo modello {what}
non si pu\xF2 codificare come {what}
Home Assistant non si \xE8 presentato in {count} s
scalderebbe a {least} \xB0C e raffredderebbe a {most} \xB0C
stato HAP {count}
il bridge di {name} non \xE8 connesso
il nodo {count} \xE8 in funzione, ma il gateway ha gi\xE0 max_nodes
il gateway Matter non ha il dispositivo {name}
il dispositivo risponde con lo stato {what}
il dispositivo risponde con l'errore {what}
l'indirizzo {name} \xE8 sconosciuto: {reason}
il tipo di contenuto {name} non si capisce
l'osservazione di {name} \xE8 finita
in {name} non si possono fare copie: {reason}
accetta {what}, e nessuna variazione
non offre {what}
non ha lo script {name}; una tabella [[gateways.ble.proxies]] lo installa
il robot non accetta ordini nel modo {what}
una pagina non pu\xF2 cambiare la tabella {name}, solo: {what}
la chiave {name} carica un programma o un file; scrivila tu
non puoi dare il diritto {name}; usa: homebot token new
nessun backup ha un byte {count}; comincia da 0
la modifica {name} non nomina nulla
l'indirizzo {name} non \xE8 pi\xF9 nel file; guardalo di nuovo
il gateway {name} \xE8 assente: {reason}
{name} non ha risposto entro {count} s; non si sa se l'ha fatto
rifiutato ({value}): {reason}
tornato dopo {count} s, {value}
non inviato: {reason}
contraddetto: {reason}
ora il nome del computer non si pu\xF2 risolvere ({what})
{name} ha l'ascensore
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
{name} non ha risposto
{name} non accetta comandi che homebot conosce
{count} dispositivi corrispondono a {name}; al massimo {most} alla volta
{what} non \xE8 stato inviato a {name}: {reason}
{what} \xE8 stato inviato a {name}: {reason}
{what} di {name}: {reason}
{name} ha gi\xE0 {what}
{name} non ha parti
{name} non \xE8 raggiungibile con TLS: {reason}
{count} proxy Bluetooth sono gi\xE0 connessi
{name} impiega pi\xF9 di {count} s per una risposta
{name} non \xE8 noto ad alcun endpoint
{name} non ha un indirizzo HTTP
{name} non ha indirizzo
{name} non risponde alle richieste
{name} non accetta messaggi
{name} ha interrotto gli eventi
{name} non si pu\xF2 annunciare come {what}: {reason}
{name}: {count} comandi aspettano gi\xE0 {what}
{name} non si pu\xF2 aprire: {reason}; {what}
{name} non si pu\xF2 aprire: {reason}
{name} non \xE8 stato impostato: {reason}
{name} si abbina con il codice che riporta: {what}
{name} \xE8 gi\xE0 in funzione
{name} \xE8 dietro il bridge {what} ({id}); si pu\xF2 rimuovere solo il bridge
{name} non risponde al server Matter
{name} non si \xE8 ancora descritto
{what} di {name} non si pu\xF2 impostare
{name} non si pu\xF2 scrivere: {reason}
{name} non si pu\xF2 mettere da parte: {reason}
{name} non \xE8 aperto
{name} non si pu\xF2 copiare: {reason}
{name} non si pu\xF2 ricreare: {reason}
{name} di {what} non pu\xF2 avere un file proprio
{name} = {what} non \xE8 un valore TOML; i testi vogliono le virgolette
{name} non pu\xF2 essere un nome: dai fino a {count} caratteri stampabili
{name} non funziona ({what}): {reason}`;export{a as reasons,n as texts};
