var n=`1c 1 aqg 2oh gn9 4 xj m4 7w 3a 2hc xg 1jt mb 6u2 1c7 2dr fsj 1du 3g5 35h 25q 3f8 58 8i6 9hb 12yl 4lo 18i 1q 320 h96 ir 5bl 1a2 1qb 57t 8b 1er d3x i46 bkg tx 8fp 1p5 75 g82 1zw 1i3 1vc a3g dq4 1mj 18i 50n cd 56y e9 3th p0 37a 38 qv dfu 41 8qh k0 1nu 5vw 1x8 41q 300 iiz 4 4z 4e7 3ua 3tz f8 7ep 24m 3ic 4w2 iy 1aw 18g k04 4k7 6m8 b4 3os 142 41v 1k8 lr 1wu az0 dmb yq1 8a7 ft 4mz 3i2 mte wv 1u 6b2 7ju j57 1r8 2cy 21t 8w9 u8 9n6 3h8 5uq 4nf m7 ma 9id 1ml oi 5ph 2bz 1pf 3zx or 33i 1 5vx yv 5e a5i 48v no 4y8 6e8 2y0 xz m2r 15w 9oh 1jt 1j6 77x 119 5w0 qo 2l ad8 1lw 2b3 of 1x5 ev6 2hl 7g9 598 ij es 9 2sc 2 agn 1r6 6t6 e 2pa 51y aux b0y 1v3 2zr 7oc d6 7wx 6i6 4oe fak 2e8 115 4v 3qy 3 1 2h6 1rq 10o ch8 70i 160 2bz 6pq jb 1qy 1fm cdm 1t7 8u9 1f 34e 2b4 j7 s1 2y5 5bj 4jv ob 4b1 5g9 3q9 d61 77y 2qs up7 c i2a 7d4 4sy ftn 5b8 23v 63h 9w3 how 3ot 6e5 962 5cb 5k8 6eu 5fa 3n8 nf0 6t 2tf 3oz l9d 1m3 j9b 6cx ag4 5m9 9n 59j 1wo 18q 33d bhk yx 7sg 8c7 ty 1t 84d h0 5vx 4oy d77 2cm 4ca 2tb ctm 6ar 4wc fk2 8f8 1h0 3t 7ry bn 10j 8aj 7x 6r3 jo7 b9 26m 18g 4l8 4me 8vf 3uy um 3zq 1hw 10c cw el 42f 5fe 1bq 2hr 1br 483 hu jh 2vm 1h7 96w t3 5uz 53l 18 h6 9th aam 22w xg 1yi 1 3hw 7m6 fv 10d po 6i5 ayk h7 6t3 2cp 3xy hu1 dl0 m9 3ml eo
no
encendido
* dispositivos
no se puede contactar con homebot
a\xF1adir
todo
seco
ventilador
# est\xE1 fuera
gas
apagado
rojo
mojado
s\xED
cerrando
puerta de garaje
cierre
desconectado
desenchufado
aseo
temperatura
azul
A\xFAn no se conoce ning\xFAn dispositivo. Aparecen aqu\xED cuando se encuentran.
sin sesi\xF3n
iniciar
libre
abriendo
pasillo
calor
abrir
en casa
permisos
# est\xE1 en casa
lavavajillas
desarmando
inaccesible
armada parcial
mostrar * ocultos
habitaciones
sal\xF3n
nombre
hacerlo
temperatura de fr\xEDo
direcci\xF3n
encender
dispositivo
c\xF3digo para $
lamas
desbloqueado
en movimiento
ocupado
\xBFMandar de todos modos?
texto
inclinaci\xF3n
volver a la base
mon\xF3xido de carbono
Puertas, sensores y otros
cerrar
luces de ~
efecto de luz
reproducci\xF3n
Grafo
lo he visto
armando
todo cerrado
deshecho
calentando
desbloqueando
desbloquear
sin calor
al contenido
toldo
c\xF3digo
fresco
pulsar
fr\xEDo
solo para mirar
aspirador
calor y fr\xEDo
encender
cortina
sin heladas
ventilaci\xF3n
sin sonido
humedad
error
sin sabotaje
techo
icono
en reposo
adelante
bloqueado
activada
Habitaci\xF3n
despu\xE9s
cortac\xE9sped
ventana
cargando
abierto
silenciado
\xDAltimamente
sustituido por una orden m\xE1s nueva
cerrado
cortando
Sin habitaci\xF3n
humo
sin problema
vistas
\xFAltimo conocido
* luces
no carga
eliminado
Seguridad
conectando \u2026
Este c\xF3digo ya no es v\xE1lido: homebot muestra otro al iniciarse.
sin vibraci\xF3n
reproduciendo
sin respuesta en >
verde
reproducir
< abierto
calor
Esa vista no existe.
vibraci\xF3n
armada fuera
m\xE1s alto
ni\xF1os
escritorio
hecho
puerta
bater\xEDa baja
naranja
M\xE1s
borrar
sin corriente
contacto
luz
con sonido
no aprobado
rechazado
Buscar
desconocido
dormitorio
encendido
fuera
oscilaci\xF3n
despacho
apagar
lugar
ahora no
caf\xE9
temperatura deseada
nevera
apagado
estor
Mantener: $
# sin cerrar
cocina
rosa
Ning\xFAn dispositivo tiene esas palabras en nombre, tipo o habitaci\xF3n.
plano
enchufe
bomba
bot\xF3n
humedad deseada
Tasas
persiana
pulsaci\xF3n
todos en casa
resumen
medida
bater\xEDa
bater\xEDa <
iluminancia
ahora <
presencia
efecto
en su base
Inicio
A esta pantalla le falta el permiso {right}. El propietario le da un token con m\xE1s permisos: Sistema, Configurar, Pantallas.
Diario
confirmado tras >
pausar
anticuado
iniciar
estado
quieto
botones, ajustes y actualizaciones: *
tira
persona
objetivo <
en silencio
opci\xF3n
parado
editar
contraventana
parar
fuera de casa
conectado
color
bater\xEDa bien
1 luz
cargando
No hay ning\xFAn dispositivo en una habitaci\xF3n ~.
limpiando
enfriando
escena
n\xFAmero
todo encendido
lavadora
Luces
armada en casa
contradicho: {saw}
* cifras
el dispositivo se elimin\xF3
pregunta
sirena
# abierto
tensi\xF3n
luz
movimiento
apagar
alguien est\xE1 fuera
Cargando los dispositivos \u2026
sonido
neutro
c\xE1lido
desarmada
A\xFAn no hay ning\xFAn dispositivo: configura tu casa.
al d\xEDa
bot\xF3n
c\xE1mara
Configurar
deshacer #
actualizaci\xF3n disponible
atr\xE1s
blanco
ba\xF1o
volumen
Configuraci\xF3n
helada
l\xE1mpara de pie
bloqueando
d\xEDa
bloquear
sabotaje
l\xE1mpara
menos
cerradura
armada de noche
no oscila
m\xE1s bajo
inseguro
en pausa
eliminar # para siempre
reciente
sin gas
rechazado ({policy}): &
s\xF3tano
termostato
lluvia
habitaci\xF3n
m\xE1s de #
armada vacaciones
amarillo
No se avisar\xE1 de nuevo a nadie.
* encendidas
enchufado
violeta
atascado
PM2,5
{state} desde >
todo apagado
enfr\xEDa a <
eliminar
consultas
cancelar
vela
corriente
problema
sin humo
desarmar
energ\xEDa
Rutinas
nueva escena
sin luz
altavoz
en casa
no se puede contactar con homebot desde >: quiz\xE1 se est\xE1 reiniciando.
Pulsar otra vez: $
seco
port\xF3n
corriente
es de antes: el dispositivo no ha informado desde que arranc\xF3 homebot.
volvi\xF3 atr\xE1s tras >
sin mon\xF3xido de carbono
Habitaciones
Plano
pausar
alarma
Sistema
comedor
Clima
Favoritos
escenas
posici\xF3n
sin lluvia
* dispositivo
garaje
jard\xEDn
valor
v\xE1lvula
Energ\xEDa
inaccesible
m\xE1s
volviendo
reserva
nivel
pendiente
seguridad
potencia
accesible
ya estaba as\xED
autom\xE1tico
seguro
lectura
interruptor
zona`;export{n as texts};
