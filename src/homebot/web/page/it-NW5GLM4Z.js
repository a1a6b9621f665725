var n=`TFzgEyDypKSnTqQWeiSQokf7cHMNuhYoTnjUXOpL7BgftW9Ee30geJJb3FIDkVJ0ZnTDA5s4OtmJW8oqrweqjc1x4455KoXJVIkFXTjrqLULJeKKCURj4M9UTdbUscWGHeQi2fTEgJ3dRJImMGmbLU1M1TOsPwzvtncOlYDIJszHjKbhQ2FMpJHKhiE2misxrbRHzC9r5220rTavQEkwlCGE7MVE9V2uNRspGXastdpXImeXgyWrP1Pvo9vn1IEaQIamM8ZBd1ISpHAplPIAkflutUs82FMlyOuFvjrDasF4CL3dP2j5TnNzo6HmfBFWiM24tmeUuYLSaRiC8pwlSc9EOIOnQ3cFF7KUTpPKFxmZM1N5LkhE96EUE1JxHHCZMmpaouYBn8ehnG2jIyLaWYgT4saN1AKe0BeR6rZXgDJDAaPSNndO47gl0zzufEKglEeSqtUFHOdGg34paNYzGkYNrso6sGz9mD5OAAMTIViAH446Wet7QSG5yFDXeTjid5bF5bxRvCOqbbZqrquOupuAIWRHHR3gMEZn8CGBmn2NWqCHCrdu0ZHS4wi4eG832KilG2cgjWLo9EKg5G1j8RjjWcBSqLZeaSqdUZZv3QAiLrATWpdvO6i4TsNRsCpKZ5CrdZcOod6BVT8MoBjUZWrDEtOwoZMmXX8bfChS2lGU6a2jHGjolq5PBUTUuwXV5JMzHh5jX1Fu7y7iX3GmhfiqttIt9Yjm2tO6Nn6D09NvFkQw9nW2kPivWXlZ5RK3SNucTSoqc99J5XXqhkWdoct7g3RsoXwAOqFdhy0RRSNuBpEzFCGAV1UzXcmbaBeGM7rGtIjT9whZgxXvIDwdboObd2hyqFzp1ZTHR6tR8zsSNVBuuxPYNO7Tg60Bg2U83vMXQNk9TEUJrNv2fQoymUTePPvtiXPump4kb903NdJ7epqIczvx
icona
dopo
soffitto
piantana
scrivania
striscia
lampada
lavastoviglie
lavatrice
frigorifero
caff\xE8
veneziana
tapparella
tenda a rullo
tenda
tenda da sole
porta
finestra
porta del garage
cancello
soggiorno
cucina
ingresso
bambini
bagno
toilette
camera da letto
studio
garage
giardino
cantina
sala da pranzo
stanza
Pianta
Routine
Diario
Sistema
Grafo
Flussi
viste
{count} dispositivo
{count} dispositivi
accesso non eseguito
connessione \u2026
homebot non \xE8 raggiungibile
homebot non \xE8 raggiungibile da {time}: forse si sta riavviando.
Questa vista non esiste.
non ora
domanda
s\xEC
no
meno
pi\xF9
altro di {name}
accendi
spegni
apri
ferma
chiudi
blocca
sblocca
premi
impostato a {value}
raffreddato a {value}
Stanza
scene
annulla {name}
fatto
annullato
Caricamento dei dispositivi \u2026
Nessun dispositivo \xE8 ancora noto. Appaiono qui appena vengono trovati.
Cerca
Nessun dispositivo ha queste parole in nome, tipo o stanza.
mostra {count} nascosti
Senza stanza
ultimo noto
\xE8 di prima: il dispositivo non ha segnalato nulla dall'avvio di homebot.
irraggiungibile
silenzioso
non approvato
recente
vecchio
valore
pianta
l'ho visto
Nessuno verr\xE0 avvisato di nuovo.
modifica
rimuovi
rimuovi {name} per sempre
nuova scena
rimosso
Comandare comunque?
rifiutato
era gi\xE0 cos\xEC
confermato dopo {time}
contraddetto: {saw}
il dispositivo \xE8 stato rimosso
nessuna risposta entro {time}
diritti
prenotazione
dispositivo
codice
non inviato: {reason}
rifiutato ({policy}): {reason}
tornato indietro dopo {time}
sostituito da un comando pi\xF9 recente
nome
sconosciuto
chiusura
luce
termostato
ventilatore
pompa
telecamera
sirena
presa
interruttore
altoparlante
scena
persona
batteria
acceso
spento
non oscilla
oscillazione
audio attivo
muto
raggiungibile
irraggiungibile
aperto
chiuso
si apre
si chiude
fermo
libero
occupato
nessun fumo
fumo
nessun monossido di carbonio
monossido di carbonio
nessun gas
gas
asciutto
bagnato
niente pioggia
pioggia
niente gelo
gelo
niente calore
calore
nessuna manomissione
manomissione
nessuna vibrazione
vibrazione
nessun suono
suono
a casa
tutti a casa
qualcuno \xE8 fuori
fermo
in movimento
inattivo
nessun problema
problema
sicuro
non sicuro
nessuna luce
luce
niente corrente
corrente
scollegato
collegato
disconnesso
connesso
bloccato
sbloccato
si blocca
si sblocca
inceppato
batteria carica
batteria scarica
non in carica
in carica
aggiornato
aggiornamento disponibile
avanti
indietro
pulisce
alla base
ritorna
in pausa
errore
zona
taglia
in riproduzione
in caricamento
disinserito
inserito in casa
inserito fuori casa
inserito notte
inserito vacanza
inserito parziale
in attesa
inserimento
disinserimento
scattato
riscalda
raffredda
spento
riscaldamento
raffreddamento
automatico
caldo e freddo
deumidificazione
ventilazione
a casa
fuori casa
acceso/spento
livello
colore
effetto
movimento
valvola
posizione
inclinazione
serratura
direzione
aspirapolvere
tosaerba
allarme
riproduzione
volume
pressione del tasto
pulsante
lettura
numero
testo
stato
luogo
contatto
presenza
sicurezza
temperatura
illuminamento
potenza
energia
tensione
corrente
misura
Casa
Sicurezza
Clima
Energia
Luci
Altro
1 luce
{count} luci
{count} accese
tutto spento
tutto chiuso
Preferiti
Stanze
stanze
riepilogo
Tieni premuto: {what}
Premi ancora: {what}
esegui
disinserisci
accendi
spegni
riproduci
metti in pausa
avvia
avvia
metti in pausa
torna alla base
batteria {value}
annulla
cancella
codice per {what}
{count} cifre
effetto luce
luci di {room}
pi\xF9 forte
pi\xF9 piano
adesso {value}
fuori
lamelle
al contenuto
bianco
candela
caldo
neutro
giorno
rosso
arancione
giallo
verde
blu
viola
rosa
{name} aperto
{name} sbloccato
{name} \xE8 a casa
{name} \xE8 via
{state} da {time}
{value} aperto
Configura
Non c'\xE8 ancora nessun dispositivo: configura la tua casa.
Questo codice non \xE8 pi\xF9 valido: homebot ne mostra un altro all'avvio.
pulsante
fresco
A questo schermo manca il diritto {right}. Il proprietario gli d\xE0 un token con pi\xF9 diritti: Sistema, Configura, Schermi.
solo da guardare
richieste
aggiungi`;export{n as texts};
