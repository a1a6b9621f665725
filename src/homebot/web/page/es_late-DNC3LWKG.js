var n=`24e 5rm 1ts 2h3 1j0 y4 2lm 2gq 5up d1 1c9 25s 2nx w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 21p 727 56y 5g 1sr 1 62v 1ir 1gj 61n nf 6pu hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 2ec 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 1zo 43 1z3 17l 6k kt f38 x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 3yo 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 6j6 18j sp 2kd 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv d5u 1lo py 29q 2os 38b 18q 5pk 66n 9jc 5hk 8l1 51 9m 32g 3b8 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 1c6 9nf 8bs 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 2hy 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 8oj fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 2y9 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 40z bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu gyh ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 2ms 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 3ne 18n 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1vg 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 1fn 6z ow 3j0 89 1qr el rb 1vc n5 5lr 1xu 5y3 1hy 4l2 cej lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 811 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o a9q 4xi 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 2xy k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 237 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 1o0 1s5 w0 1ax cx 1nh ih 2hh 18m 6h 20h al 4n8 1fo 2wz 1df 6qm 5c1 k9 1dh a8p ca 13y 10c 4rg 35s 2xg z0 1tx 2aw 2kn 3ps 29h 1d6 1ri 3w6 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
planta
el c\xF3digo es incorrecto
tiene la etiqueta always_ask
el texto
fallos del diario
Garaje
Jard\xEDn
estados perdidos
empezar de nuevo
{name} se ha descargado ({size} kB).
A\xFAn no ha informado de ning\xFAn cambio.
sensor de caudal
el dispositivo solo emite
iniciar sesi\xF3n
calidad del aire
anuncios rechazados
respuestas tard\xEDas
como el sistema
fabricante
si homebot ya funciona, preg\xFAntale: homebot doctor
conservar
archivo de datos
A\xF1adir
acepta m\xE1s de 0 y hasta 100 %
Terraza
informes
Registro
PM1
clientes cortados
di\xF3xido de carbono
Ya est\xE1 en vigor.
Por qu\xE9
En una pared
Ninguna de las {count} entradas m\xE1s recientes tiene esas palabras.
oscilaci\xF3n
En la semana de prueba lo hiciste {done} de {total} veces; una rutina acertar\xEDa entre el {low} y el {high} % de las veces.
a\xFAn no ha informado de nada desde que arranc\xF3 homebot
consulta
artista
homebot show DEVICE muestra ambos lados; homebot forget DEVICE lo termina
no tiene sensor de movimiento
acci\xF3n
durante
calor desde
A\xFAn no hay cerradura, contacto ni alarma.
baja
ahora
el servidor de Matter no tiene Bluetooth; solo llega a los dispositivos de la red
se ejecut\xF3
en bruto
etiqueta
su gateway codifica sus mensajes
seguir sin token
{issuer} pidi\xF3 {values}
reproductor de v\xEDdeo
PM10
acepta un texto
lo hiciste {time} antes
enviando \u2026
Historial
los emparejamientos con Apple Home
un programa desconocido
se apag\xF3 el servidor de Matter
darle el derecho
ninguna escena guarda uno
un c\xF3digo Matter tiene 11 o 21 cifras, o es un c\xF3digo QR que empieza por MT:
hacer
se cancel\xF3
Qu\xE9 se sabe, y de d\xF3nde
congelador
su modo es desconocido; aj\xFAstalo primero
puerto
tipos rechazados
demasiado largos
fuera de todas las habitaciones
descartados por lectura lenta
est\xE1 mojado
su otra consigna es desconocida, y ambas van juntas
respuestas desconocidas
sensor de apertura
anuncios rechazados
Alertas
actualizaci\xF3n
Se est\xE1 haciendo \u2026
Cambi\xF3 a las {time}.
por {issuer}
Una luz tenue para el camino de noche.
favorito
\xBFpila, corriente, alcance?
No entendido a las {time}:
movimiento
Diagn\xF3stico
no se puede codificar como UTF-8
presencia
las \xFAltimas 24 horas
Un servidor en este ordenador
t\xEDtulo
no hay puerto TCP libre para el broker integrado
su plantilla falla con este c\xF3digo
conexi\xF3n
Un ventilador funciona mientras el ba\xF1o est\xE1 h\xFAmedo.
avisos perdidos
deben ser segundos, 0 o m\xE1s
reiniciar homebot
No hay (o ya no hay) un dispositivo {name}.
a mano o por s\xED solo
homebot why DISPOSITIVO muestra los informes
homebot funciona de prueba y no env\xEDa nada
su efecto no dura
su plantilla no da nada para ello
Usuario
ha cambiado desde entonces; m\xEDralo otra vez
enviado en un solo mensaje al grupo {name}
se perdi\xF3 la conexi\xF3n con Home Assistant
termina
\xD3rdenes
medidor
avisos descartados
deshacer
detecta mon\xF3xido de carbono
hace la casa m\xE1s segura
inform\xF3 {values}
lleva demasiado tiempo en silencio
aprobaci\xF3n
\xBFEst\xE1 abierta la carcasa, o fuera de la pared?
en espera
tras un c\xF3digo incorrecto necesita una pausa; int\xE9ntalo m\xE1s tarde
plano con {count} habitaci\xF3n
ning\xFAn programa responde all\xED: in\xEDcialo, o corrige la direcci\xF3n
detector de humo o CO
detector de heladas
no es un puente Hue; empareja el puente al que pertenece
ha cambiado desde tu aprobaci\xF3n
{what} a lo largo del tiempo, {count} puntos
A\xFAn no ha pasado nada.
este protocolo no acepta \xF3rdenes en bruto; usa una direcci\xF3n de texto
Luz mientras alguien se mueve y est\xE1 oscuro; no se toca una l\xE1mpara ya encendida o que alguien cambie entretanto.
Qui\xE9n la usa ahora
no disponible
Un token da a esta p\xE1gina sus permisos: el tuyo es la l\xEDnea de owner.token, en la carpeta de datos de homebot. Para una tableta, crea uno con:
M\xE1s fresco sin nadie en casa, c\xE1lido con el primero que llega.
, por una persona
Como ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com los enumera todos.
la conexi\xF3n se cerr\xF3
acepta una fecha de 1970 a 2106
no hacer nada
usa un directorio en este equipo, o configura su direcci\xF3n
la tabla de un gateway tiene secretos, ninguna p\xE1gina la lee
ajuste
vuelve a instalar el homebot m\xE1s nuevo, o: homebot restore BACKUP
Aviso si el garaje queda abierto, y otra vez mientras siga.
corrige la causa del registro y luego: homebot app reload APP, o reinicia homebot
aire acondicionado
fragmentos descartados
Las nuevas pasarelas empiezan con el pr\xF3ximo inicio de homebot.
sensor de humedad
Las alertas y preguntas llegan por estas direcciones a tel\xE9fonos, chats y correo.
el control no est\xE1 en marcha; se reinicia solo, v\xE9ase Sistema
\xF3rdenes fallidas
\u2026 y {count} m\xE1s
ya no llegan eventos
no se encontr\xF3 ning\xFAn dispositivo con este c\xF3digo; \xBFest\xE1 listo para vincularse, en esta red y a\xFAn sin vincular?
Emparejado con {count} controladores.
permitido
acepta n\xFAmeros de 0 a 360, 0 a 100
usar {name}
Espera tu aprobaci\xF3n
sabotaje
Personas
se contradicen; da solo uno
Abrid las ventanas, salid y pedid ayuda
antes
, porque se aplic\xF3 la escena {scene}
guardado
, porque se deshizo la escena {scene}
desde {time}
solo acepta true
no se conoce el nombre del equipo: corrige la direcci\xF3n
Latitud
ocultarlo en la casa
observa: {name}
Las l\xEDneas aparecen aqu\xED seg\xFAn llegan.
empieza por {view}
Sal\xF3n
corrige o quita el emisor
acepta una fecha con zona horaria
Necesita: {what}
las etiquetas no aceptan \xF3rdenes
Sus dispositivos aparecen aqu\xED.
Ning\xFAn dispositivo indica a\xFAn una temperatura.
El aspirador limpia una vez al d\xEDa cuando todos se han ido.
sensor de lluvia
Un calefactor descansa mientras su ventana est\xE1 abierta.
no acepta ninguno
\xFAltima versi\xF3n
modelo
if: todo lo que debe cumplirse entonces
mensajes perdidos
dentro
hora de dormir
mensajes no guardados
el cliente {name}
falta una biblioteca
humedad del suelo
cada paso
Esta imagen ya no es reciente.
anuncios: bytes en memoria
acepta on u off
cu\xE1ndo
tras
cuarentenas
c\xE1mbiala o c\xE1rgala
una habitaci\xF3n nueva
peticiones rechazadas
Lo dice un mensaje guardado, sin decir desde cu\xE1ndo.
pulsador
velocidad
central de alarma
aspiradoras que a\xFAn no son robots
A\xFAn no hay ning\xFAn dispositivo.
calentador de agua
C\xF3digo QR
Etiquetas
no se puede contactar con \xE9l
h\xFAmedo desde
oscuro bajo
d\xEDas
imagen de {name}
usuario
{energy} devueltos
cambiar
homebot funciona sin archivo; in\xEDcialo en una carpeta con homebot.toml
Cada dispositivo tiene una habitaci\xF3n.
hora
Dormitorio
Ahora
visto por \xFAltima vez
l\xEDmite
el broker ya no responde
vincular
necesita un c\xF3digo
Copia de seguridad
a\xF1ade la tabla y reinicia homebot: docs/robots.md
el dispositivo ya no tiene esa parte
Pulsa el bot\xF3n del dispositivo y luego \xABvincular\xBB.
se perdi\xF3 la conexi\xF3n
cortac\xE9sped
las m\xE1s recientes primero
Lo que guarda esta escena no dice sus valores.
novedades perdidas
Ning\xFAn dispositivo de esta casa sirve: {what}
siguiente
encontrados y a\xFAn sin usar
grafo
no se sabe nada que una escena pueda recuperar
Esta pantalla
S\xF3tano
est\xE1 vinculado en otro sitio; qu\xEDtalo all\xED o restabl\xE9celo
un puente no tiene c\xF3digo: pulsa su bot\xF3n
Puede
descartados para ausentes
rechazados
Bajada dos tercios mientras hace calor.
{least} a {most}
Aviso si una ventana queda abierta y fuera hace fr\xEDo.
Aviso cuando se gasta mucha potencia un rato.
en reposo
una escena tiene valores que duran; para lo que se hace una vez usa una rutina
Cargando el plano \u2026
ci\xE9rralo
modo
Puertas y ventanas
accesible por
est\xE1 en la configuraci\xF3n; cambia [places] all\xED
, por {what}
M\xE1s controles
redirige demasiadas veces
Nombre, habitaci\xF3n y etiquetas
imagen
Zona horaria
Preguntando a homebot \u2026
pasarela
humidificador
Una pulsaci\xF3n en la cama: todo apagado, y aviso si algo est\xE1 abierto.
A\xFAn no hay ninguna rutina.
Tel\xE9fono en la red
frecuencia
Ni llamas ni interruptores; abrid las ventanas, salid y pedid ayuda
No hay nada que proponer.
sin respuesta
direcciones rechazadas
Temas m\xE1s activos
Nombre
otra
M\xE1s fresco de noche.
Aviso cuando una planta necesita agua.
nombra un dispositivo, o busca como 'light in hall'
propuesta por {name}
lector de etiquetas
pr\xF3xima vez
deshacer
detecta manipulaci\xF3n
Longitud
Nombre y lugar
tono de sirena
energ\xEDa del {day}
Un enchufe se apaga de noche si su aparato solo espera.
Home Assistant lo rechaza, o el c\xF3digo es incorrecto
conexiones rechazadas
Rutinas listas
{issuer} public\xF3 {text}
noche
mon\xF3xido de carbono
Luz en el pasillo cuando se abre la puerta a oscuras.
sensor de suelo
Ning\xFAn dispositivo indica a\xFAn su potencia o energ\xEDa.
tiene poca bater\xEDa
descartados por largos
si
descartados por mal formados
C\xE1lido por la ma\xF1ana y por la noche.
temperatura de color
Cada pantalla tiene su propio token, que se le puede quitar.
mensajes en espera y perdidos
redirige a otro equipo, y eso no se sigue
consultas descartadas
el directorio a\xFAn no se ha le\xEDdo
Energ\xEDa por d\xEDa
se ha activado
Planta baja
horas de silencio
hazla tuya o indica otra en HOMEBOT_DATA
when: lo que la inicia, una l\xEDnea cada uno
puede manejar
Mostrar
El c\xF3digo del dispositivo
fallos del archivo de dispositivos
anuncios: bytes de m\xE1s
Un bot\xF3n enciende y apaga una l\xE1mpara.
guardar
acepta true o false
Valores
enviado
anuncios aplazados
fr\xEDo bajo
Tus costumbres
detecta gas
mostrar
Contrase\xF1a
ajustar
no existe ese dispositivo
no tiene
Los primeros valores llegan en dos segundos.
fuga de agua
su descripci\xF3n no nombra el par\xE1metro
\xBFHay fuego? Salid y llamad a los bomberos
anuncios derivados
Se avisa de un timbrazo, y se ilumina la entrada a oscuras.
\xFAltimas veces
\xF3rdenes
sensor de temperatura
no se conoce la habitaci\xF3n del dispositivo, as\xED que puede haber alguien
Un dispositivo sin valor queda fuera.
La casa est\xE1 cerrada
temperatura ambiente
activa
robot
crear un token
sobre todo {name}
no se sabe: {names}
inofensivo
cierra el agua
el registro tiene cada uno con su traza: comun\xEDcalo o corr\xEDgelo
no hay ruta a ese equipo
no es un proxy Bluetooth; a\xF1ade "bluetooth_proxy:" a su configuraci\xF3n de ESPHome
Ba\xF1o
el broker
Aviso cuando un congelador lleva un rato demasiado caliente.
no se uni\xF3 nada a \xE9l
Ocultos
est\xE1 abierto
Esto est\xE1 ahora en homebot.toml:
no tiene orden que seguir; dale un destino
Bucle de eventos
detector
Pasillo
aprobar {name}
demasiados c\xF3digos incorrectos; descon\xE9ctalo un momento
quiz\xE1 la puerta est\xE9 abierta
enclavamiento
Sin medidor propio
Todo est\xE1 bien. A tener en cuenta:
Mensajes
Ninguna habitaci\xF3n tiene forma a\xFAn. Dale esquinas en la tabla [places.rooms], o importa un mapa: homebot places import ARCHIVO.
empieza
detecta humo o calor
contradicci\xF3n
ocultar
alta
se anunci\xF3 despu\xE9s de aprobar el dispositivo
no lo hiciste
no anunci\xF3 ninguna
ejecutar ahora
El c\xF3digo que muestra homebot run deja entrar a la primera pantalla.
energ\xEDa devuelta
inicios de sesi\xF3n fallidos
nadie se enter\xF3; [notify] y el registro dicen por qu\xE9
solo la tabla de un gateway acepta contrase\xF1a o token
Pantallas
el robot tiene una orden; pon antes su opci\xF3n en idle
valores rechazados
Ya estaba as\xED en su primer informe.
El mensaje de prueba se ha enviado.
donde est\xE1 esta pantalla
preguntar siempre
anuncios ignorados
, en camino
Valores, historial, datos
Guarda los valores actuales de:
Contiene todo lo que homebot guarda, menos las contrase\xF1as.
ese modo no tiene esa consigna
Un punto lleno est\xE1 encendido, abierto u ocupado.
Para restaurarla:
este homebot no guarda nada
homebot show DISPOSITIVO
carpeta de datos
hacen falta dos dispositivos distintos
Siete d\xEDas
localizador
a mano
Home Assistant cerr\xF3 la conexi\xF3n
el c\xF3digo es incorrecto; si est\xE1s seguro, int\xE9ntalo otra vez
identificadores cortados
la pasarela solo observa; perm\xEDtele dar \xF3rdenes en Sistema, Dispositivos
La casa est\xE1 abierta
aqu\xED no
Cambiado desde la aprobaci\xF3n anterior:
rutinas listas
indica un problema
no hay nada que deshacer, o el archivo cambi\xF3 despu\xE9s
buscando \u2026
Su \xFAltimo suceso, que no es un estado:
se hace una vez y no dura
a la casa
oscilaci\xF3n horizontal
Abre esto una vez en la pantalla; solo se muestra ahora:
El lugar da el amanecer y el atardecer; se queda aqu\xED.
el robot a\xFAn no ha dicho su estado
preajuste
desarma la alarma
sensor
tomar los valores actuales
Una l\xE1mpara luce desde el anochecer hasta la hora de dormir si hay alguien.
topics reservados
dispositivos rechazados
{name} est\xE1 vinculado.
calefactor
sin conexi\xF3n
queda
Persona
descartados (QoS 0)
brillo
since debe ir antes de until
No hay ninguna app en marcha.
acepta una fecha sin zona horaria
Cargando las rutinas \u2026
espera un minuto y mira el registro de homebot
varios nombres para un identificador: quiz\xE1 varios dispositivos
quiere varios a la vez, y no se admite
hogar
planta
el dispositivo solo puede apagarse, como una placa por seguridad
a\xFAn sin conexi\xF3n
el perfil del dispositivo no tiene trama para ello
La aprobaci\xF3n permite estas \xF3rdenes:
el token ya no vale, o es de otro
por otro programa
atr\xE1s
secreto
timbre
escribiendo \u2026
Los nodos de la izquierda publican temas, los de la derecha se suscriben.
, por s\xED mismo
caducidades descartadas
Receptor m\xE1s lento
el termostato est\xE1 en otro modo; c\xE1mbialo primero
, un eco
lo hiciste {time} despu\xE9s
aceptar
HomeKit no tiene servicio para ello
Encontrados:
inaccesible
El certificado en el que deben confiar sus dispositivos
corregirla y luego: homebot config check
intensidad de se\xF1al
A los cinco minutos muestra un reloj tenue y lo que est\xE1 abierto. La direcci\xF3n de esta pantalla:
Est\xE1 as\xED desde que homebot lo conoce.
no se envi\xF3
medidor el\xE9ctrico
parada
persiana o cortina
Cargando el grafo \u2026
Token o c\xF3digo
cerradura
enviado en un solo mensaje a la escena {name}
, por otro programa
a\xFAn no se cambi\xF3 nada
modo del ventilador
Todo est\xE1 bien.
acepta un n\xFAmero que su formato pueda expresar
Calienta con una ventana abierta
no es un JPEG, PNG, GIF o WebP de hasta 2 MiB
hace {time}
descartados por grandes
corrige el dispositivo o su anuncio
modo
t\xFA, por {what}
si empieza mientras se ejecuta
Dispositivos
Omitidos por ser secretos: {files}
enviar un mensaje de prueba
A\xFAn no se ha contado nada.
homebot no puede reiniciarse solo aqu\xED; in\xEDcialo de nuevo
retraso del bucle de eventos
el registro y homebot journal dicen m\xE1s
reinicia homebot tras una tabla nueva: docs/protocols.md
nueva rutina
frecuencia
localizar
\xF3rdenes rechazadas
el servidor de Matter es demasiado lento
despu\xE9s
con retraso de
en disputa
{name} puede controlar dispositivos
da uno, como level 40
presi\xF3n
cada vez
detector de fugas
v\xE1lvula de agua
ma\xF1ana
recibidos
da a cada dispositivo un identificador propio en sus anuncios; mientras, sus partes tienen estos nombres
todos en casa
fuga de agua
abierto mucho tiempo
ascensor
sensor de presencia
topics rechazados
ninguna orden manda a la gente a casa
mirar
perdidos
respuestas
Pulsa ahora el bot\xF3n: quedan {count} s
CoAP no tiene ese m\xE9todo
\xDAltimamente aqu\xED
do: sus pasos, una l\xEDnea cada uno
plano con {count} habitaciones
sin habitaci\xF3n
a la vez
bater\xEDa cargando
Luz y aviso cuando hay agua donde no debe.
eliminar {name}
sensor de presi\xF3n
hacer una copia
no tiene direcci\xF3n
mensajes rechazados
{nodes} nodos y {topics} temas
anuncios ambiguos
compuestos org\xE1nicos vol\xE1tiles
No se guarda nada de ese tiempo.
mirar y actuar
sensor de luz
permisos
Apps
pila baja
disyuntor
Aviso inmediato si se abre una puerta y no hay nadie en casa.
suscripciones rechazadas
rechazar
Hoy
cambi\xF3 a {values}
env\xEDa lo que su anuncio no explica
Token
habitaci\xF3n
se rechaz\xF3 a {issuer}: {reason}
Tema
homebot sabe qui\xE9n est\xE1 en casa por los tel\xE9fonos de la red y los rastreadores.
fuera
De noche se encienden y apagan l\xE1mparas sin nadie en casa.
Aviso cuando la lavadora ha terminado.
su convenci\xF3n fall\xF3
reducido
, por el dispositivo o una persona
guardarlo en este navegador
avisos fallidos
\xBFpila, corriente, alcance? Si ya no existe: homebot forget DEVICE
secando
Estudio
Colas y p\xE9rdidas
Nada de lo medido funciona.
Lo que cambias aqu\xED se ve en todas las pantallas.
sus lamas solo se abren (100) y se cierran (0)
descartados por exceso
oscuro
Sin TLS el navegador no instala ninguna aplicaci\xF3n: tls = true en [door].
versi\xF3n
conexiones fallidas
robot aspirador
Colores
valores ilegibles
una pulsaci\xF3n de su bot\xF3n
cerrar sesi\xF3n
por s\xED solo
quedan {count} s
no hay direcci\xF3n: [notify] no tiene ninguna
configuraci\xF3n err\xF3nea
Una l\xE1mpara gana luz veinte minutos antes de levantarte.
No hay imagen.
enviado otra vez
mostrar qu\xE9 permite aprobar {name}
homebot busca en el historial de cuatro semanas lo que haces una y otra vez, y lo observa una semana antes de proponerlo.
a\xFAn no se conocen los dispositivos de la casa
no se puede observar
Humo, agua, movimiento
Cocina
Se apagan todas las luces cuando todos se han ido.
Direcci\xF3n
el propietario no lo ha aprobado
caudal
humo o calor
abierto desde
, porque {device} inform\xF3 {values}
dejar que esta rutina maneje {names}
modo
Idioma
Abajo al anochecer, arriba por la ma\xF1ana.
todo
la red lo acept\xF3
buscar costumbres
no est\xE1 entre lo que el acceso puede controlar
{energy} kWh en otros d\xEDas como este
normal
sensor de calidad del aire
mensajes por segundo
en marcha
desconocido ahora
fallos
claro
infractores olvidados
uno de sus valores es desconocido
se est\xE1 vinculando otro dispositivo
En la app Casa: +, A\xF1adir accesorio, y escanea esto o escribe el c\xF3digo.
homebot place DISPOSITIVO HABITACI\xD3N
anuncios`,e=`a person must agree: {reason}
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
alguien debe aceptarlo: {reason}
no se sabe si {name} est\xE1 encendido; di on u off
ning\xFAn dispositivo encaja con {name}; {reason}
\xBFquer\xEDas decir {name}?
no se puede mandar nada cerca de {name}; excluido: {what}
no mientras {condition}: se desconoce {name}
acepta un texto con la forma {what}
acepta {what} seg\xFAn ISO 8601
una orden tiene de 1 a {count}
debe ser un texto de {count} caracteres como mucho
ya hay {count}; retira algunas
ninguna importaci\xF3n lo indica; {reason}
ya hay {count} decisiones; deshaz algunas
no tiene el anuncio {name}; tiene {what}
el puente de HomeKit no puede escuchar en {name}: {reason}
{reason}; \`at_night\` (\`--night\`) lo permite
ahora alguien duerme en {room}
no se cambi\xF3 nada, pues los valores anteriores no se pueden guardar: {reason}
no hay dispositivo ni imagen {name}
sin conexi\xF3n en {count} s
no tiene la caracter\xEDstica {name}
no se llega a ning\xFAn dispositivo: {reason}
otro proxy tiene su direcci\xF3n {name}
la interfaz {name} no sirve para multicast {value}: {reason}
no se puede abrir ning\xFAn extremo CoAP: {reason}
sin multicast {value} en la interfaz {name}: {reason}
mDNS no se puede usar en {name}: {reason}
no anunci\xF3 {name} como tema de \xF3rdenes
el broker integrado no puede escuchar: {reason}
quiere otro cifrado; {reason}
quiere {what}, y est\xE1 configurado {name}
quiere {what}, y no se admite
quiere cifrado; {reason}
quiere otra contrase\xF1a; {reason}
quiere {what}; {reason}
no cifra; {reason}
acepta un texto de {least} a {most} caracteres
acepta un texto de {count} caracteres como mucho
acepta un texto de {what} como mucho
su plantilla falla: {what}
su plantilla {what}
no se puede codificar como {what}
Home Assistant no salud\xF3 en {count} s
calentar\xEDa a {least} \xB0C y enfriar\xEDa a {most} \xB0C
estado HAP {count}
el puente de {name} no est\xE1 conectado
el nodo {count} est\xE1 en marcha, pero el gateway ya tiene max_nodes
el gateway de Matter no tiene el dispositivo {name}
el dispositivo responde con el estado {what}
el dispositivo responde con el error {what}
la direcci\xF3n {name} es desconocida: {reason}
no se entiende el tipo de contenido {name}
termin\xF3 la observaci\xF3n de {name}
no se pueden hacer copias en {name}: {reason}
acepta {what}, y ning\xFAn cambio
no ofrece {what}
no tiene el script {name}; una tabla [[gateways.ble.proxies]] lo instala
el robot no acepta \xF3rdenes en su modo {what}
una p\xE1gina no puede cambiar la tabla {name}, solo: {what}
la clave {name} carga un programa o un archivo; escr\xEDbela t\xFA
no puedes dar el derecho {name}; usa: homebot token new
ninguna copia tiene un byte {count}; empieza en 0
el cambio {name} no nombra nada
la direcci\xF3n {name} ya no est\xE1 en el archivo; m\xEDralo otra vez
el gateway {name} no est\xE1: {reason}
{name} no respondi\xF3 en {count} s; no se sabe si lo hizo
rechazado ({value}): {reason}
volvi\xF3 tras {count} s, {value}
no enviado: {reason}
contradicho: {reason}
ahora no se puede resolver el nombre del equipo ({what})
{name} tiene el ascensor
{value} cerr\xF3 la conexi\xF3n
{name} no est\xE1 conectado: {reason}
{name} no est\xE1 conectado
{name} no respondi\xF3 en {count} s
{name} duerme; int\xE9ntalo cuando despierte
{name} no est\xE1 disponible en Home Assistant
Home Assistant ya no tiene entidad para {name}
{name} no tiene controlador; \`homebot doctor\` nombra los que no sirven
no se conf\xEDa en el certificado de {name}
{what}: el servidor responde {count}, quiz\xE1 funcione m\xE1s tarde
el servidor responde {count}
pide una contrase\xF1a (estado {count})
no deja entrar a homebot con esa contrase\xF1a (estado {count})
no acepta: {value}
acepta un n\xFAmero de {least} a {most}
no tiene ese ajuste; acepta {list}
{name} no midi\xF3 ning\xFAn cambio
no hay ning\xFAn dispositivo {name}
no hay nadie en {room}
{name} nunca ha detectado a nadie; pasa una vez por delante
{name} solo se oye desde hace {count} s
{reason}, y el acceso solo permite {what}; a\xF1ade {right} en la tabla [{table}] de homebot.toml
{reason}, y el acceso solo permite {what}
un dispositivo as\xED necesita un permiso que lo nombre ({reason})
{what}, y eso prevalece {count} s m\xE1s
{value}, seg\xFAn un aviso antiguo: ahora inaccesible
{value}, seg\xFAn un aviso antiguo: visto hace {age}
{value}, seg\xFAn un aviso guardado: a\xFAn no ha informado
{name} ahora se llama {what}
{name} se rechaz\xF3 y no volver\xE1
{name} no funciona: {reason}
ya hay una rutina o app {name}; elige otro nombre, o edita esa
{name} est\xE1 en la configuraci\xF3n; c\xE1mbialo all\xED, y luego: {what}
no hay nada que deshacer: {name} no se aplic\xF3, o ya se deshizo
ya no queda nada de {name} que recuperar
ya hay una escena {name}
{name} no est\xE1 en la casa ahora; d\xE9jalo como est\xE1, o fuera
puede haber {count}; quita uno primero
{name} cambi\xF3 mientras tanto; m\xEDralo, e int\xE9ntalo de nuevo
{name} ya existe; elim\xEDnalo, o dale otro nombre al gateway
{reason}, por eso solo por su nombre: {what}
no est\xE1 emparejado: {what}
{name} no est\xE1 emparejado con homebot
la \xFAltima recarga se rechaz\xF3: {reason}
sin respuesta en {count} s
demasiados c\xF3digos sin efecto conocido de {issuer}
no mientras {condition}, y el estado de {name} es desconocido: {reason}
hay alguien en {room}: {name} estaba activo hace {count} s, y desde entonces no se abri\xF3 ninguna puerta
puede haber alguien en {room}: {name} cambi\xF3 hace {count} s, y ninguna orden lo explica
{name} necesita un permiso que lo nombre ({reason}), y {issuer} no lo tiene{what}
{name} necesita un permiso, porque {reason}, y {issuer} no lo tiene{what}
no est\xE1 en la lista de dispositivos inofensivos ({what})
mantenido en {value} por {holder} hasta que se libere
mantenido en {value} por {holder} {count} s m\xE1s
mantenido por {holder} hasta que se libere: {value}
mantenido por {holder} {count} s m\xE1s: {value}
{name} dijo que no
nadie respondi\xF3 en {count} s: se hace en la p\xE1gina o con \`homebot answer\`
son las {time}, y hay silencio de {start} a {end}
hay alguien en {room}: {what}
hab\xEDa alguien en {room} hace {count} s: {what}
puede haber alguien en {room}: {what}
no se sabe si hay alguien en {room}: {reason}
{name} cambi\xF3 {count} veces en {span} s
no mientras {condition}: {what}
el miembro {name} lo rechaza: {reason}
{issuer} no puede controlar {name}, solo: {what}
{issuer} no puede controlar {name}: {reason}
no se puede contactar con ning\xFAn dispositivo: {reason}
no se puede contactar con {name}: {reason}
{name} no est\xE1 en la red ahora
se perdi\xF3 la conexi\xF3n con {name}
tipo: {value}
tipo: {value}
se llama {name}
su unidad es {name}
calienta hasta {count} \xB0C
junto a otra parte: {reason}
el nombre {name} dice {what}
el modelo {name} dice {what}
la pasarela {name} no dice su estado
problema de {name}
abandonado por {name}
fallos en {name} desde el inicio
contado por {name} en los \xFAltimos diez minutos
contado por {name} desde el inicio
en cuarentena en {name}, que solo lee una parte de sus mensajes
nota sobre {name}
pasarela {name}: {value}, env\xEDa \xF3rdenes
pasarela {name}: {value}, solo observa: {reason}
pasarela {name}: {value}, solo observa
pasarela {name}: {value}: {reason}
{reason} Tras reiniciar homebot: {keys}
El archivo no ha cambiado: {reason}
{count} dispositivos esperan aprobaci\xF3n y no reciben nada antes: {list}
1 dispositivo espera aprobaci\xF3n y no recibe nada antes: {list}
el \xFAltimo mensaje no se envi\xF3: {reason}
visto hace {age}
hecho: {what}
omitido: no {what}
{what} fall\xF3: {reason}
{value} ({count} %)
{value}, desde hace {age}
{name} no es seguro ({reason}), y {value}; apru\xE9balo con {what}
la regla fall\xF3: {what}
{count} \xF3rdenes esperan su resultado
su pasarela {name} est\xE1 {value}: {reason}
su pasarela {name} est\xE1 {value}
{name} no respondi\xF3 en {count} s: {what}
nadie escucha {what}
su bot\xF3n no se puls\xF3 en {count} s; p\xFAlsalo e int\xE9ntalo otra vez
{name} no se vincul\xF3: {reason}
{what} se rechaz\xF3: {reason}
{name} no tiene imagen
{id}: {name} no vio efecto de su \xFAltima orden; una vez reparado, \`homebot trust {what}\`
{name} ({reason})
acepta: {what}
esta parte acepta: {list}
ninguno de sus modos: {list}
el dispositivo responde: {what}
{name} ya est\xE1 vinculado con homebot
{name} depende del puente {what}, que se vincula entero
{reason}; otra vez en {count} s
desde aqu\xED, solo: {value}
ya hay una habitaci\xF3n {name}
{name} ya se llama as\xED
{name} est\xE1 vinculado con otro sistema; qu\xEDtalo all\xED o restabl\xE9celo, luego {what}
{name} se elimin\xF3
{name} se cambi\xF3
{name} se a\xF1adi\xF3
{name} dijo que s\xED
{name} no responde
{name} no respondi\xF3
{name} no acepta \xF3rdenes que homebot conozca
{count} dispositivos encajan con {name}; como mucho {most} a la vez
{what} no se envi\xF3 a {name}: {reason}
{what} se envi\xF3 a {name}: {reason}
{what} de {name}: {reason}
{name} ya tiene {what}
{name} no tiene ninguna parte
no se llega a {name} con TLS: {reason}
ya hay {count} proxies Bluetooth conectados
{name} tarda m\xE1s de {count} s en responder
{name} no se conoce en ning\xFAn extremo
{name} no tiene direcci\xF3n HTTP
{name} no tiene direcci\xF3n
{name} no responde a peticiones
{name} no acepta mensajes
{name} termin\xF3 los eventos
{name} no se puede anunciar como {what}: {reason}
{name}: {count} \xF3rdenes esperan ya a {what}
{name} no se puede abrir: {reason}; {what}
{name} no se puede abrir: {reason}
{name} no se ajust\xF3: {reason}
{name} se empareja con el c\xF3digo que lleva: {what}
{name} ya est\xE1 puesto en marcha
{name} est\xE1 tras el puente {what} ({id}); solo se puede quitar el puente
{name} no responde al servidor de Matter
{name} a\xFAn no se ha descrito
no se puede ajustar {what} de {name}
no se puede escribir {name}: {reason}
no se puede apartar {name}: {reason}
{name} no est\xE1 abierto
no se puede copiar {name}: {reason}
no se puede volver a crear {name}: {reason}
{name} de {what} no cabe en un archivo propio
{name} = {what} no es un valor de TOML; los textos llevan comillas
{name} no puede ser un nombre: da hasta {count} caracteres imprimibles
{name} falla ({what}): {reason}`;export{e as reasons,n as texts};
