var n=`29 1 fh 1mf 14y 5lx gd 6tu 71n 41y ss 19r acd 8e6 98l 58m g9 84r 2lt afv 6 2el 77 1q2 v8 2ca 4lj 24l fp 1c 4c3 1qf 28f 18a 6e1 2s9 i4b 5vd 6ab 227 2ej 6u f 6yl u6 5 5qc 9d7 48s lil byg 5ek 79r 6sy 8bf 17i 3lh 5t 7zt 28g 5no 7hp f2v 82u 2gg 1tq 2w2 34s 6m6 34n e8m 811 2nm 7wa 148 1js 997 2rl 9iu au1 3am wv 1fl 4xa eb 9cj z63 65z 1cs 406 12g zm 55h 5t 1hq 2n4 4v 4ie 1ft zp 222 2q 7jr ebv z7 cuh 2ku 3at adl 4jh 6uf 2lg 447 2d0 3e4 t4 lr 47l 2ns xm 9b 1 289 z1 222 12u 8zb 4te 9nk a8k i9x 11o acw 52a d87 1 5cy v6 6gs 2p0 th 9l7 75p 44x 8lb k3 144 9r 4w6 7ms 4li d4c 9er 223 542 2cd 34x il 37d 3qn 1pg mg 9c5 9mo 768 uo f3p 8gw 2cf ax anf 1kw i1d 3ku 346 716 47z 1qc 200 8 4nw 4ly 1c5 37q 3yo 4en 1jm 105 ob 1 71 2gp 5v0 1a1 6o3 1wg 1cj i6 5fo 32k 4n5 2zo 2gk eei 763 14y 4o9 zf 2h7 74i 1jw gxh 7la bmd 4xu 4x9 1ec 4r5 3qt 7cp 6in 52y 58p rw 62z 5pq 84k 2yz 3o0 f4p 5 1 6xk 7sv 1g7 640 k 3pw 142 bmc q78 36n 4o5 14z 8v4 251 6mp 43q 212 192 42a 71t 11n 1cv 4dc wf 3xe g4 dvp 7vd 7s7 23f 2lm 2h3 3xl ls 4sv 1ds 64f tk 2u gk8 33r 9gp l8v 25g 5go gjq 3o6 1gi 7pz 3ac 235 2l9 3gz zm 7o7 97j 4nr 2uz enn 18s 20q 7cx 9vq 637 23a 7r5 2xi 8gw 2pp dri j 344 34i j bxh 9c 6z6 1lg aey gsz 3lr da6 2lp 3i 3nv 1c0 mtg it 14c hx 5ic 41x 2iz 245 7ck 90o
no
encendido
deshecho
lugar
resumen
direcci\xF3n
A\xFAn no hay ning\xFAn dispositivo: configura tu casa.
todo apagado
reproduciendo
humedad deseada
PM2,5
comedor
reproducir
ocupado
desconocido
botones, ajustes y actualizaciones: *
bot\xF3n
reproducci\xF3n
problema
a\xF1adir
todo
volumen
seco
ventilador
gas
desarmando
apagado
Mantener: $
Sistema
rojo
mojado
s\xED
parado
humedad
pausar
parar
Plano
lavavajillas
reserva
rosa
autom\xE1tico
plano
enchufe
\xDAltimamente
bomba
bot\xF3n
nivel
sabotaje
apagado
\xBFMandar de todos modos?
ventilaci\xF3n
ya estaba as\xED
blanco
s\xF3tano
editar
armada en casa
sin luz
es de antes: el dispositivo no ha informado desde que arranc\xF3 homebot.
violeta
opci\xF3n
silenciado
lamas
alarma
oscilaci\xF3n
Energ\xEDa
atascado
inseguro
corriente
bater\xEDa
enfriando
activada
sin sabotaje
A\xFAn no se conoce ning\xFAn dispositivo. Aparecen aqu\xED cuando se encuentran.
Cargando los dispositivos \u2026
pendiente
Sin habitaci\xF3n
volvi\xF3 atr\xE1s tras >
escenas
despacho
persiana
no oscila
en silencio
apagar
atr\xE1s
el dispositivo se elimin\xF3
n\xFAmero
confirmado tras >
mon\xF3xido de carbono
{state} desde >
cocina
mostrar * ocultos
vibraci\xF3n
movimiento
pausar
error
abierto
Diario
cortac\xE9sped
luces de ~
libre
en casa
sin mon\xF3xido de carbono
m\xE1s de #
efecto
* encendidas
A esta pantalla le falta el permiso {right}. El propietario le da un token con m\xE1s permisos: Sistema, Configurar, Pantallas.
al d\xEDa
posici\xF3n
contradicho: {saw}
sin calor
Buscar
reciente
sin gas
no carga
con sonido
escritorio
tensi\xF3n
sin vibraci\xF3n
Este c\xF3digo ya no es v\xE1lido: homebot muestra otro al iniciarse.
texto
hecho
puerta
eliminar
inclinaci\xF3n
desenchufado
luz
altavoz
volviendo
encender
rechazado
abriendo
eliminar # para siempre
verde
abrir
valor
v\xE1lvula
icono
en reposo
apagar
cerrando
rechazado ({policy}): &
cierre
sin problema
Tasas
lo he visto
persona
calentando
temperatura
ahora no
no se puede contactar con homebot
m\xE1s alto
luz
sin lluvia
potencia
1 luz
* luces
lavadora
l\xE1mpara de pie
# sin cerrar
nombre
cerrar
armada fuera
calor y fr\xEDo
Esa vista no existe.
armada de noche
pregunta
* dispositivo
desbloqueado
conectado
alguien est\xE1 fuera
todo encendido
sal\xF3n
solo para mirar
* cifras
m\xE1s bajo
actualizaci\xF3n disponible
seguro
lectura
c\xF3digo
fresco
c\xF3digo para $
zona
sin respuesta en >
efecto de luz
desarmar
sin corriente
sin sonido
cancelar
enchufado
desbloqueando
vela
desarmada
presencia
temperatura deseada
desbloquear
puerta de garaje
cortando
habitaciones
accesible
< abierto
ahora <
sustituido por una orden m\xE1s nueva
no se puede contactar con homebot desde >: quiz\xE1 se est\xE1 reiniciando.
interruptor
todos en casa
Inicio
pasillo
encender
calor
cargando
en casa
* dispositivos
# est\xE1 en casa
sonido
termostato
Grafo
inaccesible
aseo
conectando \u2026
borrar
contacto
fuera de casa
helada
en pausa
M\xE1s
Ning\xFAn dispositivo tiene esas palabras en nombre, tipo o habitaci\xF3n.
armada parcial
m\xE1s
dormitorio
anticuado
iniciar
estado
quieto
tira
No se avisar\xE1 de nuevo a nadie.
bloqueando
permisos
nueva escena
armando
bloquear
d\xEDa
Habitaci\xF3n
lluvia
azul
# abierto
habitaci\xF3n
Configuraci\xF3n
Configurar
fuera
color
c\xE1mara
sirena
bater\xEDa <
al contenido
sin heladas
contraventana
en movimiento
hacerlo
armada vacaciones
enfr\xEDa a <
dispositivo
garaje
jard\xEDn
ni\xF1os
volver a la base
objetivo <
port\xF3n
toldo
bater\xEDa bien
No hay ning\xFAn dispositivo en una habitaci\xF3n ~.
c\xE1lido
fr\xEDo
temperatura de fr\xEDo
Habitaciones
bloqueado
cortina
caf\xE9
pulsar
calor
naranja
ventana
Seguridad
corriente
l\xE1mpara
menos
neutro
cerradura
despu\xE9s
escena
limpiando
Favoritos
inaccesible
sin sesi\xF3n
en su base
eliminado
pulsaci\xF3n
Clima
seco
# est\xE1 fuera
nevera
vistas
Pulsar otra vez: $
todo cerrado
consultas
no aprobado
desconectado
sin humo
estor
medida
seguridad
iluminancia
energ\xEDa
techo
ba\xF1o
\xFAltimo conocido
adelante
deshacer #
bater\xEDa baja
encendido
Puertas, sensores y otros
aspirador
cargando
cerrado
Luces
amarillo
Rutinas
iniciar
humo`;export{n as texts};
