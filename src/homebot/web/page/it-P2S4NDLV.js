var n=`29 1 fh 1mf 14y 5lx gd 6tu 71n 41y ss 19r acd 8e6 98l 58m g9 84r 2lt afv 6 2el 77 1q2 v8 2ca 4lj 24l fp 1c 4c3 1qf 28f 18a 6e1 2s9 i4b 5vd 6ab 227 2ej 6u f 6yl u6 5 5qc 9d7 48s lil byg 5ek 79r 6sy 8bf 17i 3lh 5t 7zt 28g 5no 7hp f2v 82u 2gg 1tq 2w2 34s 6m6 34n e8m 811 2nm 7wa 148 1js 997 2rl 9iu au1 3am wv 1fl 4xa eb 9cj z63 65z 1cs 406 12g zm 55h 5t 1hq 2n4 4v 4ie 1ft zp 222 2q 7jr ebv z7 cuh 2ku 3at adl 4jh 6uf 2lg 447 2d0 3e4 t4 lr 47l 2ns xm 9b 1 289 z1 222 12u 8zb 4te 9nk a8k i9x 11o acw 52a d87 1 5cy v6 6gs 2p0 th 9l7 75p 44x 8lb k3 144 9r 4w6 7ms 4li d4c 9er 223 542 2cd 34x il 37d 3qn 1pg mg 9c5 9mo 768 uo f3p 8gw 2cf ax anf 1kw i1d 3ku 346 716 47z 1qc 200 8 4nw 4ly 1c5 37q 3yo 4en 1jm 105 ob 1 71 2gp 5v0 1a1 6o3 1wg 1cj i6 5fo 32k 4n5 2zo 2gk eei 763 14y 4o9 zf 2h7 74i 1jw gxh 7la bmd 4xu 4x9 1ec 4r5 3qt 7cp 6in 52y 58p rw 62z 5pq 84k 2yz 3o0 f4p 5 1 6xk 7sv 1g7 640 k 3pw 142 bmc q78 36n 4o5 14z 8v4 251 6mp 43q 212 192 42a 71t 11n 1cv 4dc wf 3xe g4 dvp 7vd 7s7 23f 2lm 2h3 3xl ls 4sv 1ds 64f tk 2u gk8 33r 9gp l8v 25g 5go gjq 3o6 1gi 7pz 3ac 235 2l9 3gz zm 7o7 97j 4nr 2uz enn 18s 20q 7cx 9vq 637 23a 7r5 2xi 8gw 2pp dri j 344 34i j bxh 9c 6z6 1lg aey gsz 3lr da6 2lp 3i 3nv 1c0 mtg it 14c hx 5ic 41x 2iz 245 7ck 90o
no
acceso
annullato
luogo
riepilogo
direzione
Non c'\xE8 ancora nessun dispositivo: configura la tua casa.
tutto spento
in riproduzione
umidit\xE0 impostata
PM2,5
sala da pranzo
riproduci
occupato
sconosciuto
pulsanti, impostazioni e aggiornamenti: *
pulsante
riproduzione
problema
aggiungi
tutto
volume
asciutto
ventilatore
gas
disinserimento
spento
Tieni premuto: $
Sistema
rosso
bagnato
s\xEC
fermo
umidit\xE0
metti in pausa
ferma
Pianta
lavastoviglie
prenotazione
rosa
automatico
pianta
presa
Di recente
pompa
pulsante
livello
manomissione
spento
Comandare comunque?
ventilazione
era gi\xE0 cos\xEC
bianco
cantina
modifica
inserito in casa
nessuna luce
\xE8 di prima: il dispositivo non ha segnalato nulla dall'avvio di homebot.
viola
scelta
muto
lamelle
allarme
oscillazione
Energia
inceppato
non sicuro
corrente
batteria
raffredda
scattato
nessuna manomissione
Nessun dispositivo \xE8 ancora noto. Appaiono qui appena vengono trovati.
Caricamento dei dispositivi \u2026
in attesa
Senza stanza
tornato indietro dopo >
scene
studio
veneziana
non oscilla
silenzioso
spegni
indietro
il dispositivo \xE8 stato rimosso
numero
confermato dopo >
monossido di carbonio
{state} da >
cucina
mostra * nascosti
vibrazione
movimento
metti in pausa
errore
aperto
Diario
tosaerba
luci di ~
libero
a casa
nessun monossido di carbonio
altro di #
effetto
* accese
A questo schermo manca il diritto {right}. Il proprietario gli d\xE0 un token con pi\xF9 diritti: Sistema, Configura, Schermi.
aggiornato
posizione
contraddetto: {saw}
niente calore
Cerca
recente
nessun gas
non in carica
audio attivo
scrivania
tensione
nessuna vibrazione
Questo codice non \xE8 pi\xF9 valido: homebot ne mostra un altro all'avvio.
testo
fatto
porta
rimuovi
inclinazione
scollegato
luce
altoparlante
ritorna
accendi
rifiutato
si apre
rimuovi # per sempre
verde
apri
valore
valvola
icona
inattivo
spegni
si chiude
rifiutato ({policy}): &
chiusura
nessun problema
Flussi
l'ho visto
persona
riscalda
temperatura
non ora
homebot non \xE8 raggiungibile
pi\xF9 forte
luce
niente pioggia
potenza
1 luce
* luci
lavatrice
piantana
# sbloccato
nome
chiudi
inserito fuori casa
caldo e freddo
Questa vista non esiste.
inserito notte
domanda
* dispositivo
sbloccato
connesso
qualcuno \xE8 fuori
tutto acceso
soggiorno
solo da guardare
* cifre
pi\xF9 piano
aggiornamento disponibile
sicuro
lettura
codice
fresco
codice per $
zona
nessuna risposta entro >
effetto luce
disinserisci
niente corrente
nessun suono
annulla
collegato
si sblocca
candela
disinserito
presenza
temperatura impostata
sblocca
porta del garage
taglia
stanze
raggiungibile
< aperto
adesso <
sostituito da un comando pi\xF9 recente
homebot non \xE8 raggiungibile da >: forse si sta riavviando.
interruttore
tutti a casa
Casa
ingresso
accendi
calore
in carica
a casa
* dispositivi
# \xE8 a casa
suono
termostato
Grafo
irraggiungibile
toilette
connessione \u2026
cancella
contatto
fuori casa
gelo
in pausa
Altro
Nessun dispositivo ha queste parole in nome, tipo o stanza.
inserito parziale
pi\xF9
camera da letto
vecchio
avvia
stato
fermo
striscia
Nessuno verr\xE0 avvisato di nuovo.
si blocca
diritti
nuova scena
inserimento
blocca
giorno
Stanza
pioggia
blu
# aperto
stanza
Configurazione
Configura
fuori
colore
telecamera
sirena
batteria <
al contenuto
niente gelo
tapparella
in movimento
esegui
inserito vacanza
raffreddato a <
dispositivo
garage
giardino
bambini
torna alla base
impostato a <
cancello
tenda da sole
batteria carica
Non c'\xE8 nessun dispositivo in una stanza ~.
caldo
raffreddamento
temperatura di raffreddamento
Stanze
bloccato
tenda
caff\xE8
premi
riscaldamento
arancione
finestra
Sicurezza
corrente
lampada
meno
neutro
serratura
dopo
scena
pulisce
Preferiti
irraggiungibile
accesso non eseguito
alla base
rimosso
pressione del tasto
Clima
deumidificazione
# \xE8 via
frigorifero
viste
Premi ancora: $
tutto chiuso
richieste
non approvato
disconnesso
nessun fumo
tenda a rullo
misura
sicurezza
illuminamento
energia
soffitto
bagno
ultimo noto
avanti
annulla #
batteria scarica
acceso/spento
Porte, sensori e altro
aspirapolvere
in caricamento
chiuso
Luci
giallo
Routine
avvia
fumo`;export{n as texts};
