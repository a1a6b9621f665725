var n=`fbMUyZpzuCwbve3cb9chcon2YzFLpv2nffRtFBS561OQ36t2S9eef2FjmbbriCY2k7luAzl6mtcPDFUOrsk0XIZrZ2tVgyMvTlmZL73zJj0wxAjA9YXIBayWFGJImpY9AcJbuvLqzEJwmBqfgoEjJa7T17MgJbBBuEynOqelVG9VoztuLerutpIyZRKhSstJXbuLjQxDfC8ePvhHwOUAf68yjWpm4uTBR2yzVUm2h2GkSNf94TFOfVHxQnFQVVZX72iy1spbGaq9HJkkFKu0PIQMvz8q8KT6TlNc5B1DDpQYmGgcGcHw4tiWo6koip3tKT9vIUxvhUGRYtZIhMPQ1adUHbftMg0eUxlhoYrktFzXMm9U1HKZuIsVifyXtHaWDSLMOEgXUUl9wYOB1H3emz0jcgcQgADO1s9GfnjEoWvSQZRN2x8jqcAR6Ah954VfgKwHEg9KP7LlnvcrCINZvlrqq857oIO1YkZYsR6eN8bRTPwJfgWCjxHz8BXocF3iiTUxrWC51kXezAvxNOkPI94Hn6gAWrsVaAWlNv8BA1DKhsRWbgMvtEJm8lElWULqmIfATwpU04OREI0F4IoTEfoJVB7EzLawrBEC8do8J4Dv7CB5jI0qfehTwqUzo7mKdB6DSetJjTP8vwZJVQwDzgT7z3tJ4qGQrRdRAyFurHbrFs0KO47nrDyHmZX3TU08aVmilm8tCYRou5GQRyV0wbT1O6B2ENgbhhvbCF6MiAkct8RrPoRzaIpnJXwaXfSDo5xbm9N1JbpKuFeOe4O3kqYx7g3gG7zs0IyEwYqQHiETJsA4AorORcpqStHdtwcjJLfrHeEQKWBA6lFzScU5qpcUVO59CorPpo3BGtzdJDM9Tarftxf3TP8DpVOfdLh9QbeSd984V7323SP746XxMOE4SnIR4RWLsB6wczeFFnNGwgn6BtIZJw7kcqMnGMiOlI4PC9ZFZY9QxkKYLYfVVh3W
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
Non c'\xE8 nessun dispositivo in una stanza {room}.
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
rifiutato ({policy}): {reason}
tornato indietro dopo {time}
sostituito da un comando pi\xF9 recente
tutto
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
scelta
numero
testo
stato
luogo
contatto
presenza
sicurezza
temperatura
umidit\xE0
illuminamento
potenza
energia
tensione
corrente
PM2,5
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
tutto acceso
tutto chiuso
Porte, sensori e altro
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
Di recente
batteria {value}
pulsanti, impostazioni e aggiornamenti: {count}
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
Configurazione
Non c'\xE8 ancora nessun dispositivo: configura la tua casa.
Questo codice non \xE8 pi\xF9 valido: homebot ne mostra un altro all'avvio.
pulsante
fresco
A questo schermo manca il diritto {right}. Il proprietario gli d\xE0 un token con pi\xF9 diritti: Sistema, Configura, Schermi.
solo da guardare
richieste
aggiungi
temperatura impostata
temperatura di raffreddamento
umidit\xE0 impostata`;export{n as texts};
