var n=`24e 5rm 1ts 2b7 5w 1j0 y4 rn 1pz 40 2gq 5up d1 1c9 25s 105 nh 10b w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 93w 56y 5g 1sr 1 62v 1ir 1gj av 5qs nf 23f 4mf hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 ot 1pj 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 8q 1qy 43 1z3 17l 6k kt 9zn 53l x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 2se 16a 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 2pb 3tv 18j sp 9b 1l2 q0 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv 4z0 14d 72h 1lo py 29q 2os 38b 18q 1e6 4be 66n 9jc 53k e0 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 4l 17l 9nf 38l sw 4ab 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 36 2es 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 3d1 5bi fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 159 1t0 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 3i8 ir bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu 8zc 7z5 ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 1o2 yq 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 2nz zf g2 sl 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1ls 9o 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 60 19n 6z ow 1y4 1kw 89 1qr el rb 1vc n5 39k k2 1s5 1xu 5y3 1hy 4l2 bp1 pi lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 5e8 2mt 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o 3uo 6f2 jx 4dl 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 1mc 179 4d k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 7 230 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 5j 1ih 1s5 w0 1ax cx 1nh ih 2hh 18m 6h sj 17y al q7 3x1 1fo 2wz 1df 6qm 5c1 k9 1dh 6l a1n h ca 13y 10c 4rg 35s 25z rh z0 123 ru 2aw 2kn 3j5 6n 29h 1d6 3p8 1yg 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
pianta
il codice \xE8 sbagliato
ha l'etichetta always_ask
il dispositivo \xE8 in servizio, ma i suoi attributi non si sono potuti leggere
il testo
errori del diario
Garage
non accetta comandi; segnala soltanto
tinta (0 a 360) e saturazione (0 a 100), come 0,100 per rosso o 240,50 per azzurro
Giardino
stati persi
ricomincia
# \xE8 stato scaricato ({size} kB).
Non ha ancora segnalato cambiamenti.
sensore di flusso
un'altra chiave
solo un'app o una routine pu\xF2 averne uno, con la sua chiave \`act\`
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
Nessuna delle * voci pi\xF9 recenti ha queste parole.
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
l'hai fatto > prima
invio \u2026
Cronologia
gli abbinamenti con Apple Home
un programma sconosciuto
il server Matter \xE8 stato spento
dalle il diritto
nessuna scena ne conserva uno
il dispositivo risponde con un errore
un codice Matter ha 11 o 21 cifre, o \xE8 un codice QR che inizia con MT:
fai
la stanza del dispositivo
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
non c'\xE8 D-Bus; su Linux, bluetoothd e il bus di sistema devono essere in esecuzione
\xC8 in corso \u2026
\xC8 cambiato alle >.
da {issuer}
Una luce tenue per il cammino di notte.
preferito
batteria, corrente, portata?
Non capito alle >:
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
lo storico non \xE8 iniziato, o non viene conservato; \`homebot doctor\` dice perch\xE9
riavvia homebot
Non c'\xE8 (pi\xF9) un dispositivo #.
a mano o da solo
homebot why DISPOSITIVO mostra le segnalazioni
homebot gira in prova e non invia nulla
il suo effetto non dura
contenuti
il suo modello non d\xE0 nulla per questo
Utente
\xE8 cambiato nel frattempo; guardalo di nuovo
inviato in un solo messaggio al gruppo #
la connessione a Home Assistant \xE8 caduta
finisce
Comandi
contatore
notifiche scartate
annulla
segnala monossido di carbonio
non c'\xE8 una via per i comandi
rende la casa pi\xF9 sicura
ha segnalato {values}
\xE8 silenzioso da troppo tempo
approvazione
La custodia \xE8 aperta, o \xE8 staccato dal muro?
in attesa
dopo un codice sbagliato vuole una pausa; riprova pi\xF9 tardi
pianta con * stanza
nessun programma risponde l\xEC: avvialo, o correggi l'indirizzo
rilevatore di fumo o CO
rilevatore di gelo
non \xE8 un bridge Hue; abbina il bridge a cui appartiene
\xE8 cambiato da quando lo hai approvato
$ nel tempo, * punti
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
ha appena annunciato altri topic per i comandi, forse di un altro dispositivo; riprova
climatizzatore
frammenti scartati
I nuovi gateway iniziano al prossimo avvio di homebot.
aspetta, al massimo un minuto, i dispositivi di prima; riprova
il suo bridge non lo raggiunge
sensore di umidit\xE0
Allarmi e domande arrivano con questi indirizzi a telefoni, chat e posta.
il controllo non \xE8 in funzione; si riavvia da solo, vedi Sistema
comandi falliti
\u2026 e altri *
non arrivano pi\xF9 eventi
nessun dispositivo trovato con questo codice; \xE8 pronto per l'associazione, in questa rete e non gi\xE0 associato?
Abbinato a * controller.
permesso
accetta numeri da 0 a 360, da 0 a 100
usa #
In attesa della tua approvazione
manomissione
Persone
si contraddicono; danne uno solo
Aprite le finestre, uscite e chiamate aiuto
prima
, perch\xE9 \xE8 stata applicata la scena {scene}
salvato
, perch\xE9 \xE8 stata annullata la scena {scene}
da >
accetta solo true
il nome del computer \xE8 sconosciuto: correggi l'indirizzo
Latitudine
nascondilo nella casa
osserva: #
Le righe appaiono qui man mano.
inizia con {view}
Soggiorno
correggi o togli il mittente
accetta una data con fuso orario
Serve: $
i tag non accettano comandi
I suoi dispositivi compaiono qui.
Nessun dispositivo indica ancora una temperatura.
L'aspirapolvere pulisce una volta al giorno quando tutti sono usciti.
sensore di pioggia
Un riscaldamento riposa finch\xE9 la sua finestra \xE8 aperta.
\`homebot find\` mostra ci\xF2 che va bene
indica password_file o password_env in [gateways.mdns.drivers.shelly]
non ne accetta
ultima versione
modello
if: tutto ci\xF2 che deve valere allora
messaggi persi
dentro
ora di dormire
valori
messaggi non conservati
il client #
libreria mancante
ci ha messo troppo
umidit\xE0 del terreno
ogni passo
Questa immagine non \xE8 pi\xF9 recente.
annunci: byte in memoria
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
immagine di #
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
Nessun dispositivo di questa casa \xE8 adatto: $
rifiuta la password di password_file o password_env in [gateways.mdns.drivers.shelly]
avanti
trovati, e non ancora usati
\xE8 occupato
orari e la casa
grafo
non se ne sa nulla che una scena possa ripristinare
Questo schermo
Cantina
\xE8 associato altrove; rimuovilo l\xEC o ripristinalo
un bridge non ha codice: premi il suo pulsante
Pu\xF2
scartati per assenti
rifiutati
l'indirizzo di un flusso, come una radio
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
, a causa di $
Altri comandi
reindirizza troppo spesso
Nome, stanza ed etichette
non ha risposto in tempo
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
un'altra password
Nome
altra
Pi\xF9 fresco di notte.
Un avviso quando una pianta ha bisogno d'acqua.
nomina un dispositivo, o cerca come 'light in hall'
proposta da #
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
senza dare un motivo
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
un numero finito
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
questa domanda non c'\xE8 pi\xF9; \`homebot answer\` elenca quelle aperte
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
soprattutto #
non noto: {names}
innocuo
chiudi l'acqua
il registro ha ognuno con la sua traccia: segnalalo o correggilo
nessun percorso verso quel computer
non \xE8 un proxy Bluetooth; aggiungi "bluetooth_proxy:" alla sua configurazione ESPHome
Bagno
ricreato
il broker
risponde solo una persona, sulla pagina
Un avviso quando un congelatore \xE8 troppo caldo per un po'.
niente vi \xE8 stato unito
Nascosti
\xE8 aperto
Ora in homebot.toml c'\xE8:
non ha un ordine da proseguire; dagli una destinazione
Ciclo degli eventi
rilevatore
Ingresso
approva #
troppi codici sbagliati; scollegalo un momento
la porta \xE8 forse aperta
interblocco
Senza contatore proprio
Va tutto bene. Da notare:
Messaggi
True o False
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
nessun annuncio valido dall'avvio di questo gateway; riavvia il dispositivo o il suo bridge, o aspetta
non c'\xE8 nulla da annullare, o il file \xE8 cambiato da allora
ricerca \u2026
Il suo ultimo evento, che non \xE8 uno stato:
una sola password andrebbe in chiaro a chi si chiama cos\xEC: aggiungi "api: encryption:" alla sua configurazione ESPHome e dai key_file, o il suo indirizzo IP fisso come allow_plaintext_at in [gateways.mdns.drivers.esphome.devices.NAME]
si fa una volta e non dura
alla casa
oscillazione orizzontale
Apri questo una volta sullo schermo; viene mostrato solo ora:
Il luogo d\xE0 alba e tramonto; resta qui.
il robot non ha ancora detto il suo stato
preimpostazione
la sua memoria \xE8 piena
nessun indirizzo
disinserisce l'allarme
sensore
prendi i valori attuali
Una lampada \xE8 accesa dal tramonto all'ora di dormire se c'\xE8 qualcuno.
topic riservati
il bridge risponde qualcosa di sconosciuto
dispositivi rifiutati
# \xE8 associato.
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
dai a homebot una cartella in cui scrivere (HOMEBOT_DATA), o avvialo con --ephemeral
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
l'hai fatto > dopo
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
inviato in un solo messaggio alla scena #
, da un altro programma
non \xE8 ancora cambiato nulla
modalit\xE0 ventola
Va tutto bene.
accetta un numero che il suo formato pu\xF2 esprimere
Riscalda con una finestra aperta
non \xE8 un JPEG, PNG, GIF o WebP fino a 2 MiB
> fa
scartati, troppo grandi
correggi il dispositivo o il suo annuncio
modalit\xE0
tu, con $
se parte mentre \xE8 in corso
Dispositivi
Esclusi perch\xE9 segreti: {files}
invia un messaggio di prova
Non \xE8 ancora contato nulla.
on o off
homebot qui non pu\xF2 riavviarsi da solo; riavvialo
nessuna via per quella rete
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
# pu\xF2 comandare i dispositivi
danne uno, come level 40
pressione
ogni volta
rilevatore di perdite
valvola dell'acqua
mattina
ricevuti
bluetoothd non \xE8 in esecuzione
una password
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
Premi ora il pulsante: ancora * s
CoAP non ha questo metodo
Di recente qui
do: i suoi passi, una riga ciascuno
un testo
pianta con * stanze
senza stanza
insieme
batteria in carica
Luce e un avviso quando c'\xE8 acqua dove non deve.
rimuovi #
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
dai la chiave che la sua configurazione ESPHome ha sotto "api: encryption:" come key_file, o nessuna
stanza
{issuer} \xE8 stato rifiutato: &
Argomento
homebot sa chi \xE8 in casa dai telefoni nella rete e dai tracker.
fuori casa
Di sera lampade si accendono e spengono se nessuno \xE8 in casa.
Un avviso quando la lavatrice ha finito.
la sua convenzione \xE8 fallita
abbassato
, dal dispositivo o da una persona
dall'avvio di questo gateway non ha detto che cosa sa fare; forse dorme: sveglialo, e riprova
conservalo in questo browser
notifiche fallite
un'altra cifratura
batteria, corrente, portata? Se non c'\xE8 pi\xF9: homebot forget DEVICE
asciuga
Studio
Code e perdite
Nulla di misurato \xE8 in funzione.
Ci\xF2 che cambi qui si vede su ogni schermo.
le lamelle si aprono (100) e si chiudono (0) soltanto
scartati, troppi
un numero
questo homebot non ha routine
scuro
Senza TLS il browser non installa l'app: tls = true in [door].
versione
connessioni fallite
robot aspirapolvere
Colori
la cifratura
valori illeggibili
una pressione del suo pulsante
copiato
esci
da solo
ancora * s
niente
non c'\xE8 un indirizzo: [notify] non ne ha
configurazione errata
Una lampada si schiarisce per venti minuti prima che ti alzi.
lo stato della casa
inviato di nuovo
mostra che cosa permette l'approvazione di #
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
annunci`,o=`# asks, so another answers: use the owner's token, and give programs their own
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
# \xE8 stato commutato * volte in {span} s$
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
^ # non pu\xF2 essere <: &
nessun endpoint CoAP si pu\xF2 aprire: &
niente multicast < sull'interfaccia #: &
mDNS non si pu\xF2 usare su #: &
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
