var n=`fbMUyZpzuCwbve3cb9chcon2YzFLpv2nffRtFBS561OQ36t2S9eef2FjmbbriCY2k7luAzl6mtcPDFUOrsk0XIZrZ2tVgyMvTlmZL73zJj0wxAjA9YXIBayWFGJImpY9AcJbuvLqzEJwmBqfgoEjJa7T17MgJbBBuEynOqelVG9VoztuLerutpIyZRKhSstJXbuLjQxDfC8ePvhHwOUAf68yjWpm4uTBR2yzVUm2h2GkSNf94TFOfVHxQnFQVVZX72iy1spbGaq9HJkkFKu0PIQMvz8q8KT6TlNc5B1DDpQYmGgcGcHw4tiWo6koip3tKT9vIUxvhUGRYtZIhMPQ1adUHbftMg0eUxlhoYrktFzXMm9U1HKZuIsVifyXtHaWDSLMOEgXUUl9wYOB1H3emz0jcgcQgADO1s9GfnjEoWvSQZRN2x8jqcAR6Ah954VfgKwHEg9KP7LlnvcrCINZvlrqq857oIO1YkZYsR6eN8bRTPwJfgWCjxHz8BXocF3iiTUxrWC51kXezAvxNOkPI94Hn6gAWrsVaAWlNv8BA1DKhsRWbgMvtEJm8lElWULqmIfATwpU04OREI0F4IoTEfoJVB7EzLawrBEC8do8J4Dv7CB5jI0qfehTwqUzo7mKdB6DSetJjTP8vwZJVQwDzgT7z3tJ4qGQrRdRAyFurHbrFs0KO47nrDyHmZX3TU08aVmilm8tCYRou5GQRyV0wbT1O6B2ENgbhhvbCF6MiAkct8RrPoRzaIpnJXwaXfSDo5xbm9N1JbpKuFeOe4O3kqYx7g3gG7zs0IyEwYqQHiETJsA4AorORcpqStHdtwcjJLfrHeEQKWBA6lFzScU5qpcUVO59CorPpo3BGtzdJDM9Tarftxf3TP8DpVOfdLh9QbeSd984V7323SP746XxMOE4SnIR4RWLsB6wczeFFnNGwgn6BtIZJw7kcqMnGMiOlI4PC9ZFZY9QxkKYLYfVVh3W
icono
despu\xE9s
techo
l\xE1mpara de pie
escritorio
tira
l\xE1mpara
lavavajillas
lavadora
nevera
caf\xE9
persiana
contraventana
estor
cortina
toldo
puerta
ventana
puerta de garaje
port\xF3n
sal\xF3n
cocina
pasillo
ni\xF1os
ba\xF1o
aseo
dormitorio
despacho
garaje
jard\xEDn
s\xF3tano
comedor
habitaci\xF3n
Plano
Rutinas
Diario
Sistema
Grafo
Tasas
vistas
{count} dispositivo
{count} dispositivos
sin sesi\xF3n
conectando \u2026
no se puede contactar con homebot
no se puede contactar con homebot desde {time}: quiz\xE1 se est\xE1 reiniciando.
Esa vista no existe.
ahora no
pregunta
s\xED
no
menos
m\xE1s
m\xE1s de {name}
encender
apagar
abrir
parar
cerrar
bloquear
desbloquear
pulsar
objetivo {value}
enfr\xEDa a {value}
Habitaci\xF3n
escenas
deshacer {name}
hecho
deshecho
Cargando los dispositivos \u2026
A\xFAn no se conoce ning\xFAn dispositivo. Aparecen aqu\xED cuando se encuentran.
Buscar
Ning\xFAn dispositivo tiene esas palabras en nombre, tipo o habitaci\xF3n.
mostrar {count} ocultos
No hay ning\xFAn dispositivo en una habitaci\xF3n {room}.
Sin habitaci\xF3n
\xFAltimo conocido
es de antes: el dispositivo no ha informado desde que arranc\xF3 homebot.
inaccesible
en silencio
no aprobado
reciente
anticuado
valor
plano
lo he visto
No se avisar\xE1 de nuevo a nadie.
editar
eliminar
eliminar {name} para siempre
nueva escena
eliminado
\xBFMandar de todos modos?
rechazado
ya estaba as\xED
confirmado tras {time}
contradicho: {saw}
el dispositivo se elimin\xF3
sin respuesta en {time}
permisos
reserva
dispositivo
c\xF3digo
rechazado ({policy}): {reason}
volvi\xF3 atr\xE1s tras {time}
sustituido por una orden m\xE1s nueva
todo
nombre
desconocido
cierre
luz
termostato
ventilador
bomba
c\xE1mara
sirena
enchufe
interruptor
altavoz
escena
persona
bater\xEDa
encendido
apagado
no oscila
oscilaci\xF3n
con sonido
silenciado
accesible
inaccesible
abierto
cerrado
abriendo
cerrando
parado
libre
ocupado
sin humo
humo
sin mon\xF3xido de carbono
mon\xF3xido de carbono
sin gas
gas
seco
mojado
sin lluvia
lluvia
sin heladas
helada
sin calor
calor
sin sabotaje
sabotaje
sin vibraci\xF3n
vibraci\xF3n
sin sonido
sonido
en casa
todos en casa
alguien est\xE1 fuera
quieto
en movimiento
en reposo
sin problema
problema
seguro
inseguro
sin luz
luz
sin corriente
corriente
desenchufado
enchufado
desconectado
conectado
bloqueado
desbloqueado
bloqueando
desbloqueando
atascado
bater\xEDa bien
bater\xEDa baja
no carga
cargando
al d\xEDa
actualizaci\xF3n disponible
adelante
atr\xE1s
limpiando
en su base
volviendo
en pausa
error
zona
cortando
reproduciendo
cargando
desarmada
armada en casa
armada fuera
armada de noche
armada vacaciones
armada parcial
pendiente
armando
desarmando
activada
calentando
enfriando
apagado
calor
fr\xEDo
autom\xE1tico
calor y fr\xEDo
seco
ventilaci\xF3n
en casa
fuera de casa
encendido
nivel
color
efecto
movimiento
v\xE1lvula
posici\xF3n
inclinaci\xF3n
cerradura
direcci\xF3n
aspirador
cortac\xE9sped
alarma
reproducci\xF3n
volumen
pulsaci\xF3n
bot\xF3n
lectura
opci\xF3n
n\xFAmero
texto
estado
lugar
contacto
presencia
seguridad
temperatura
humedad
iluminancia
potencia
energ\xEDa
tensi\xF3n
corriente
PM2,5
medida
Inicio
Seguridad
Clima
Energ\xEDa
Luces
M\xE1s
1 luz
{count} luces
{count} encendidas
todo apagado
todo encendido
todo cerrado
Puertas, sensores y otros
Favoritos
Habitaciones
habitaciones
resumen
Mantener: {what}
Pulsar otra vez: {what}
hacerlo
desarmar
encender
apagar
reproducir
pausar
iniciar
iniciar
pausar
volver a la base
\xDAltimamente
bater\xEDa {value}
botones, ajustes y actualizaciones: {count}
cancelar
borrar
c\xF3digo para {what}
{count} cifras
efecto de luz
luces de {room}
m\xE1s alto
m\xE1s bajo
ahora {value}
fuera
lamas
al contenido
blanco
vela
c\xE1lido
neutro
d\xEDa
rojo
naranja
amarillo
verde
azul
violeta
rosa
{name} abierto
{name} sin cerrar
{name} est\xE1 en casa
{name} est\xE1 fuera
{state} desde {time}
{value} abierto
Configurar
Configuraci\xF3n
A\xFAn no hay ning\xFAn dispositivo: configura tu casa.
Este c\xF3digo ya no es v\xE1lido: homebot muestra otro al iniciarse.
bot\xF3n
fresco
A esta pantalla le falta el permiso {right}. El propietario le da un token con m\xE1s permisos: Sistema, Configurar, Pantallas.
solo para mirar
consultas
a\xF1adir
temperatura deseada
temperatura de fr\xEDo
humedad deseada`;export{n as texts};
