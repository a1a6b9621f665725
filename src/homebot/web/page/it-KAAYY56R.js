var n=`1c 1 aqg 2oh gn9 4 xj m4 7w 3a 2hc xg 1jt mb 6u2 1c7 2dr fsj 1du 3g5 35h 25q 3f8 58 8i6 9hb 12yl 4lo 18i 1q 320 h96 ir 5bl 1a2 1qb 57t 8b 1er d3x i46 bkg tx 8fp 1p5 75 g82 1zw 1i3 1vc a3g dq4 1mj 18i 50n cd 56y e9 3th p0 37a 38 qv dfu 41 8qh k0 1nu 5vw 1x8 41q 300 iiz 4 4z 4e7 3ua 3tz f8 7ep 24m 3ic 4w2 iy 1aw 18g k04 4k7 6m8 b4 3os 142 41v 1k8 lr 1wu az0 dmb yq1 8a7 ft 4mz 3i2 mte wv 1u 6b2 7ju j57 1r8 2cy 21t 8w9 u8 9n6 3h8 5uq 4nf m7 ma 9id 1ml oi 5ph 2bz 1pf 3zx or 33i 1 5vx yv 5e a5i 48v no 4y8 6e8 2y0 xz m2r 15w 9oh 1jt 1j6 77x 119 5w0 qo 2l ad8 1lw 2b3 of 1x5 ev6 2hl 7g9 598 ij es 9 2sc 2 agn 1r6 6t6 e 2pa 51y aux b0y 1v3 2zr 7oc d6 7wx 6i6 4oe fak 2e8 115 4v 3qy 3 1 2h6 1rq 10o ch8 70i 160 2bz 6pq jb 1qy 1fm cdm 1t7 8u9 1f 34e 2b4 j7 s1 2y5 5bj 4jv ob 4b1 5g9 3q9 d61 77y 2qs up7 c i2a 7d4 4sy ftn 5b8 23v 63h 9w3 how 3ot 6e5 962 5cb 5k8 6eu 5fa 3n8 nf0 6t 2tf 3oz l9d 1m3 j9b 6cx ag4 5m9 9n 59j 1wo 18q 33d bhk yx 7sg 8c7 ty 1t 84d h0 5vx 4oy d77 2cm 4ca 2tb ctm 6ar 4wc fk2 8f8 1h0 3t 7ry bn 10j 8aj 7x 6r3 jo7 b9 26m 18g 4l8 4me 8vf 3uy um 3zq 1hw 10c cw el 42f 5fe 1bq 2hr 1br 483 hu jh 2vm 1h7 96w t3 5uz 53l 18 h6 9th aam 22w xg 1yi 1 3hw 7m6 fv 10d po 6i5 ayk h7 6t3 2cp 3xy hu1 dl0 m9 3ml eo
no
acceso
* dispositivi
homebot non \xE8 raggiungibile
aggiungi
tutto
asciutto
ventilatore
# \xE8 via
gas
spento
rosso
bagnato
s\xEC
si chiude
porta del garage
chiusura
disconnesso
scollegato
toilette
temperatura
blu
Nessun dispositivo \xE8 ancora noto. Appaiono qui appena vengono trovati.
accesso non eseguito
avvia
libero
si apre
ingresso
calore
apri
a casa
diritti
# \xE8 a casa
lavastoviglie
disinserimento
irraggiungibile
inserito parziale
mostra * nascosti
stanze
soggiorno
nome
esegui
temperatura di raffreddamento
direzione
accendi
dispositivo
codice per $
lamelle
sbloccato
in movimento
occupato
Comandare comunque?
testo
inclinazione
torna alla base
monossido di carbonio
Porte, sensori e altro
chiudi
luci di ~
effetto luce
riproduzione
Grafo
l'ho visto
inserimento
tutto chiuso
annullato
riscalda
si sblocca
sblocca
niente calore
al contenuto
tenda da sole
codice
fresco
premi
raffreddamento
solo da guardare
aspirapolvere
caldo e freddo
accendi
tenda
niente gelo
ventilazione
nessun suono
umidit\xE0
errore
nessuna manomissione
soffitto
icona
inattivo
avanti
bloccato
scattato
Stanza
dopo
tosaerba
finestra
in caricamento
aperto
muto
Di recente
sostituito da un comando pi\xF9 recente
chiuso
taglia
Senza stanza
fumo
nessun problema
viste
ultimo noto
* luci
non in carica
rimosso
Sicurezza
connessione \u2026
Questo codice non \xE8 pi\xF9 valido: homebot ne mostra un altro all'avvio.
nessuna vibrazione
in riproduzione
nessuna risposta entro >
verde
riproduci
< aperto
riscaldamento
Questa vista non esiste.
vibrazione
inserito fuori casa
pi\xF9 forte
bambini
scrivania
fatto
porta
batteria scarica
arancione
Altro
cancella
niente corrente
contatto
luce
audio attivo
non approvato
rifiutato
Cerca
sconosciuto
camera da letto
acceso/spento
fuori
oscillazione
studio
spegni
luogo
non ora
caff\xE8
temperatura impostata
frigorifero
spento
tenda a rullo
Tieni premuto: $
# sbloccato
cucina
rosa
Nessun dispositivo ha queste parole in nome, tipo o stanza.
pianta
presa
pompa
pulsante
umidit\xE0 impostata
Flussi
veneziana
pressione del tasto
tutti a casa
riepilogo
misura
batteria
batteria <
illuminamento
adesso <
presenza
effetto
alla base
Casa
A questo schermo manca il diritto {right}. Il proprietario gli d\xE0 un token con pi\xF9 diritti: Sistema, Configura, Schermi.
Diario
confermato dopo >
metti in pausa
vecchio
avvia
stato
fermo
pulsanti, impostazioni e aggiornamenti: *
striscia
persona
impostato a <
silenzioso
scelta
fermo
modifica
tapparella
ferma
fuori casa
connesso
colore
batteria carica
1 luce
in carica
Non c'\xE8 nessun dispositivo in una stanza ~.
pulisce
raffredda
scena
numero
tutto acceso
lavatrice
Luci
inserito in casa
contraddetto: {saw}
* cifre
il dispositivo \xE8 stato rimosso
domanda
sirena
# aperto
tensione
luce
movimento
spegni
qualcuno \xE8 fuori
Caricamento dei dispositivi \u2026
suono
neutro
caldo
disinserito
Non c'\xE8 ancora nessun dispositivo: configura la tua casa.
aggiornato
pulsante
telecamera
Configura
annulla #
aggiornamento disponibile
indietro
bianco
bagno
volume
Configurazione
gelo
piantana
si blocca
giorno
blocca
manomissione
lampada
meno
serratura
inserito notte
non oscilla
pi\xF9 piano
non sicuro
in pausa
rimuovi # per sempre
recente
nessun gas
rifiutato ({policy}): &
cantina
termostato
pioggia
stanza
altro di #
inserito vacanza
giallo
Nessuno verr\xE0 avvisato di nuovo.
* accese
collegato
viola
inceppato
PM2,5
{state} da >
tutto spento
raffreddato a <
rimuovi
richieste
annulla
candela
corrente
problema
nessun fumo
disinserisci
energia
Routine
nuova scena
nessuna luce
altoparlante
a casa
homebot non \xE8 raggiungibile da >: forse si sta riavviando.
Premi ancora: $
deumidificazione
cancello
corrente
\xE8 di prima: il dispositivo non ha segnalato nulla dall'avvio di homebot.
tornato indietro dopo >
nessun monossido di carbonio
Stanze
Pianta
metti in pausa
allarme
Sistema
sala da pranzo
Clima
Preferiti
scene
posizione
niente pioggia
* dispositivo
garage
giardino
valore
valvola
Energia
irraggiungibile
pi\xF9
ritorna
prenotazione
livello
in attesa
sicurezza
potenza
raggiungibile
era gi\xE0 cos\xEC
automatico
sicuro
lettura
interruttore
zona`;export{n as texts};
