var e=`24e 5rm 1ts 2b7 5w 1j0 y4 rn 1pz 40 2gq 5up d1 1c9 25s 105 nh 10b w7 il 1ow 109 1qe 44w 3z id 7yk 5qv 14g iw 61n 1ul 3g6 ku ll 3f1 1hl 1yd 10k 2g1 1oc o5 wy 2f 10u 8v nn 2c9 1qf 1a0 26v 1qf 2vn kx 1 1qf m8 2ms 312 1on 84 93w 56y 5g 1sr 1 62v 1ir 1gj av 5qs nf 23f 4mf hp 35f 2y9 10e 36f xv hf zg ef xn h0 2t0 md ec 40 ot 1pj 4cg 2k1 1nw 5jw 19v 47w 3e0 2wt 8s an 6vj 1al 2a4 st 1tj 4ff 64j 38b 1be 8q 1qy 43 1z3 17l 6k kt 9zn 53l x6 58 1im 9x 24s 16z 2l3 uh 3s3 11j 2se 16a 1x6 164 29w 272 1h6 2yb 13c 36o 3ol jf 54w b 8li 233 1jf 415 463 101 1lp 2vn 2u5 41m 11l 16e 41z cw 131 ny o3 4qd 5r8 2pb 3tv 18j sp 9b 1l2 q0 1qy 10u 1fh 5gx 23n 3h5 hh 4e fg bx 1ei 1c3 h6 6n 6tg 19i ij 243 us ss sc m8 md 4ku 353 2h1 z1 4ys 6nt 2o8 98 21z 7lk 88c ji f2 gv 4z0 14d 72h 1lo py 29q 2os 38b 18q 1e6 4be 66n 9jc 53k e0 8l1 51 9m 6do 16t 69b 1b xm 2un 1d7 1a8 1ba 4vr 83f nd 3o7 16o c6 7e8 10j 4 5 1cr 12a bc 1lb 5op 3tm 1i4 4uf 13p r1 1n1 mh fso gp 1a5 2i 182 bp 62u 2a0 5g3 jo cm wk 4l 17l 9nf 38l sw 4ab 5ar 1b3 2vv y2 5zn 1xy 1cg d4j 36 2es 1yk kc vp 8i9 2ey 17z 70 1cw xs 507 24o 1n8 1lj 1nb 9m 3d1 5bi fv 1g0 3ph 1c2 lm 1f0 62 5hs ag as1 66m 2cg ti 159 1t0 ge 72 3y7 5p5 1lh 4q8 3nv 5s 288 2ss 9n 1o sf 5kd 38j 2bi od 20t bee 1g7 3i8 ir bn 598 fm 2r2 jf 1ma 9n ar 2rg 8gp 1nz 1vo zu 8zc 7z5 ym 23s 1go l c1 25g 1b9 84t fy ot 18v 8h 12s qw 1n1 8e 13 7a 14e 10j ec 2kg pi qe 56d np cf 70w 1o2 yq 146 2x v2 fz dv 1yp et 5cw j8 ms 14j 1b0 1ji 1o3 l2 16k 3oz 1ni z 2nz zf g2 sl 372 rt 2la 16 21x qi 2hs aw6 2qa 61h 1do 169 2a2 7u x5 1ls 9o 2m 3x0 2t1 c0 3 d6 b9 1oi cr 4be 2r2 3uo 39k ep 1rk 3j kz 1jv 100 gh aa 390 u3 m2 3sb 1ni 878 2we 26o 1tg hq 7o pa 5pl 3ei 2xk dm 3gu 35n jv 1vd 85 52v 19o 1af 60 19n 6z ow 1y4 1kw 89 1qr el rb 1vc n5 39k k2 1s5 1xu 5y3 1hy 4l2 bp1 pi lr 45a 91 9r 1hy dfu 2gz 1a6 337 5w8 lw 5e8 2mt 2kh 4al x7 1k9 1cg 2eh em 2tq 7sy 151 2tm df 33m 154 eo 6qe 8mc 68l 1l1 3xd 1uy p 1y1 2nu 1p 1dy 8l4 403 7k1 3b0 2ho 6dc 2om 65u 3gi 1s4 r3 b8 o9 k8 2vb h4 16k 2j6 8i5 37e mi 32h 4qs 4e 4zn 2q7 2uv 7k 4o 3uo 6f2 jx 4dl 2gj 3m1 2de 19f 203 ea 2b3 ib 5x2 7nh i2 20q 7gi 3gv 9kb 27p 2si 57f 1mc 179 4d k2 3le 1vj 1lf 2hu 9w 29l 66 3 5tk 6u 4re 6bq 8dt 7 230 4nc 6it nr 3gq 26v 38l 1pl 30u te rp er o9 8f 68x 45j 4yu 840 1f4 1j8 3dd dv 2s6 1b5 2kq 20i 1hd 5j 1ih 1s5 w0 1ax cx 1nh ih 2hh 18m 6h sj 17y al q7 3x1 1fo 2wz 1df 6qm 5c1 k9 1dh 6l a1n h ca 13y 10c 4rg 35s 25z rh z0 123 ru 2aw 2kn 3j5 6n 29h 1d6 3p8 1yg 22k e oe 1o9 90i 4u 104 60 np 1u2 hr 3oo 3ay wd 6tj 2bf 1v6 3nd el 2vy 6bj 33 1vf 2lg ap b1 1rq it 4vq 18q gk tj 20v 4h6 q3
planta
el c\xF3digo es incorrecto
tiene la etiqueta always_ask
el dispositivo est\xE1 en servicio, pero no se pudieron leer sus atributos
el texto
fallos del diario
Garaje
no acepta \xF3rdenes; solo informa
tono (0 a 360) y saturaci\xF3n (0 a 100), como 0,100 para rojo o 240,50 para azul p\xE1lido
Jard\xEDn
estados perdidos
empezar de nuevo
# se ha descargado ({size} kB).
A\xFAn no ha informado de ning\xFAn cambio.
sensor de caudal
otra clave
solo una app o una rutina puede tener uno, por su clave \`act\`
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
Ninguna de las * entradas m\xE1s recientes tiene esas palabras.
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
lo hiciste > antes
enviando \u2026
Historial
los emparejamientos con Apple Home
un programa desconocido
se apag\xF3 el servidor de Matter
darle el derecho
ninguna escena guarda uno
el dispositivo responde con un error
un c\xF3digo Matter tiene 11 o 21 cifras, o es un c\xF3digo QR que empieza por MT:
hacer
la habitaci\xF3n del dispositivo
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
no hay D-Bus; en Linux, bluetoothd y el bus del sistema deben estar en marcha
Se est\xE1 haciendo \u2026
Cambi\xF3 a las >.
por {issuer}
Una luz tenue para el camino de noche.
favorito
\xBFpila, corriente, alcance?
No entendido a las >:
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
el historial no ha empezado, o no se guarda; \`homebot doctor\` dice por qu\xE9
reiniciar homebot
No hay (o ya no hay) un dispositivo #.
a mano o por s\xED solo
homebot why DISPOSITIVO muestra los informes
homebot funciona de prueba y no env\xEDa nada
su efecto no dura
medios
su plantilla no da nada para ello
Usuario
ha cambiado desde entonces; m\xEDralo otra vez
enviado en un solo mensaje al grupo #
se perdi\xF3 la conexi\xF3n con Home Assistant
termina
\xD3rdenes
medidor
avisos descartados
deshacer
detecta mon\xF3xido de carbono
no hay v\xEDa para \xF3rdenes
hace la casa m\xE1s segura
inform\xF3 {values}
lleva demasiado tiempo en silencio
aprobaci\xF3n
\xBFEst\xE1 abierta la carcasa, o fuera de la pared?
en espera
tras un c\xF3digo incorrecto necesita una pausa; int\xE9ntalo m\xE1s tarde
plano con * habitaci\xF3n
ning\xFAn programa responde all\xED: in\xEDcialo, o corrige la direcci\xF3n
detector de humo o CO
detector de heladas
no es un puente Hue; empareja el puente al que pertenece
ha cambiado desde tu aprobaci\xF3n
$ a lo largo del tiempo, * puntos
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
acaba de anunciar otros temas de \xF3rdenes, quiz\xE1 de otro dispositivo; int\xE9ntalo otra vez
aire acondicionado
fragmentos descartados
Las nuevas pasarelas empiezan con el pr\xF3ximo inicio de homebot.
espera, un minuto como mucho, a los dispositivos de antes; int\xE9ntalo otra vez
su puente no lo alcanza
sensor de humedad
Las alertas y preguntas llegan por estas direcciones a tel\xE9fonos, chats y correo.
el control no est\xE1 en marcha; se reinicia solo, v\xE9ase Sistema
\xF3rdenes fallidas
\u2026 y * m\xE1s
ya no llegan eventos
no se encontr\xF3 ning\xFAn dispositivo con este c\xF3digo; \xBFest\xE1 listo para vincularse, en esta red y a\xFAn sin vincular?
Emparejado con * controladores.
permitido
acepta n\xFAmeros de 0 a 360, 0 a 100
usar #
Espera tu aprobaci\xF3n
sabotaje
Personas
se contradicen; da solo uno
Abrid las ventanas, salid y pedid ayuda
antes
, porque se aplic\xF3 la escena {scene}
guardado
, porque se deshizo la escena {scene}
desde >
solo acepta true
no se conoce el nombre del equipo: corrige la direcci\xF3n
Latitud
ocultarlo en la casa
observa: #
Las l\xEDneas aparecen aqu\xED seg\xFAn llegan.
empieza por {view}
Sal\xF3n
corrige o quita el emisor
acepta una fecha con zona horaria
Necesita: $
las etiquetas no aceptan \xF3rdenes
Sus dispositivos aparecen aqu\xED.
Ning\xFAn dispositivo indica a\xFAn una temperatura.
El aspirador limpia una vez al d\xEDa cuando todos se han ido.
sensor de lluvia
Un calefactor descansa mientras su ventana est\xE1 abierta.
\`homebot find\` muestra lo que sirve
pon password_file o password_env en [gateways.mdns.drivers.shelly]
no acepta ninguno
\xFAltima versi\xF3n
modelo
if: todo lo que debe cumplirse entonces
mensajes perdidos
dentro
hora de dormir
valores
mensajes no guardados
el cliente #
falta una biblioteca
tard\xF3 demasiado
humedad del suelo
cada paso
Esta imagen ya no es reciente.
anuncios: bytes en memoria
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
imagen de #
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
Ning\xFAn dispositivo de esta casa sirve: $
rechaza la contrase\xF1a de password_file o password_env en [gateways.mdns.drivers.shelly]
siguiente
encontrados y a\xFAn sin usar
est\xE1 ocupado
horas y la casa
grafo
no se sabe nada que una escena pueda recuperar
Esta pantalla
S\xF3tano
est\xE1 vinculado en otro sitio; qu\xEDtalo all\xED o restabl\xE9celo
un puente no tiene c\xF3digo: pulsa su bot\xF3n
Puede
descartados para ausentes
rechazados
la direcci\xF3n de un flujo, como una radio
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
, por $
M\xE1s controles
redirige demasiadas veces
Nombre, habitaci\xF3n y etiquetas
no respondi\xF3 a tiempo
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
otra contrase\xF1a
Nombre
otra
M\xE1s fresco de noche.
Aviso cuando una planta necesita agua.
nombra un dispositivo, o busca como 'light in hall'
propuesta por #
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
sin dar motivo
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
un n\xFAmero finito
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
esa pregunta ya no existe; \`homebot answer\` muestra las abiertas
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
sobre todo #
no se sabe: {names}
inofensivo
cierra el agua
el registro tiene cada uno con su traza: comun\xEDcalo o corr\xEDgelo
no hay ruta a ese equipo
no es un proxy Bluetooth; a\xF1ade "bluetooth_proxy:" a su configuraci\xF3n de ESPHome
Ba\xF1o
recreado
el broker
solo responde una persona, en la p\xE1gina
Aviso cuando un congelador lleva un rato demasiado caliente.
no se uni\xF3 nada a \xE9l
Ocultos
est\xE1 abierto
Esto est\xE1 ahora en homebot.toml:
no tiene orden que seguir; dale un destino
Bucle de eventos
detector
Pasillo
aprobar #
demasiados c\xF3digos incorrectos; descon\xE9ctalo un momento
quiz\xE1 la puerta est\xE9 abierta
enclavamiento
Sin medidor propio
Todo est\xE1 bien. A tener en cuenta:
Mensajes
True o False
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
sin anuncio v\xE1lido desde que arranc\xF3 esta pasarela; reinicia el dispositivo o su puente, o espera
no hay nada que deshacer, o el archivo cambi\xF3 despu\xE9s
buscando \u2026
Su \xFAltimo suceso, que no es un estado:
una contrase\xF1a sola ir\xEDa sin cifrar a quien se llame as\xED: a\xF1ade "api: encryption:" a su configuraci\xF3n de ESPHome y da key_file, o su direcci\xF3n IP fija como allow_plaintext_at en [gateways.mdns.drivers.esphome.devices.NAME]
se hace una vez y no dura
a la casa
oscilaci\xF3n horizontal
Abre esto una vez en la pantalla; solo se muestra ahora:
El lugar da el amanecer y el atardecer; se queda aqu\xED.
el robot a\xFAn no ha dicho su estado
preajuste
no le queda memoria
ninguna direcci\xF3n
desarma la alarma
sensor
tomar los valores actuales
Una l\xE1mpara luce desde el anochecer hasta la hora de dormir si hay alguien.
topics reservados
el puente responde algo desconocido
dispositivos rechazados
# est\xE1 vinculado.
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
da a homebot una carpeta donde pueda escribir (HOMEBOT_DATA), o arr\xE1ncalo con --ephemeral
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
lo hiciste > despu\xE9s
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
enviado en un solo mensaje a la escena #
, por otro programa
a\xFAn no se cambi\xF3 nada
modo del ventilador
Todo est\xE1 bien.
acepta un n\xFAmero que su formato pueda expresar
Calienta con una ventana abierta
no es un JPEG, PNG, GIF o WebP de hasta 2 MiB
hace >
descartados por grandes
corrige el dispositivo o su anuncio
modo
t\xFA, por $
si empieza mientras se ejecuta
Dispositivos
Omitidos por ser secretos: {files}
enviar un mensaje de prueba
A\xFAn no se ha contado nada.
on u off
homebot no puede reiniciarse solo aqu\xED; in\xEDcialo de nuevo
sin ruta a esa red
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
# puede controlar dispositivos
da uno, como level 40
presi\xF3n
cada vez
detector de fugas
v\xE1lvula de agua
ma\xF1ana
recibidos
bluetoothd no est\xE1 en marcha
una contrase\xF1a
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
Pulsa ahora el bot\xF3n: quedan * s
CoAP no tiene ese m\xE9todo
\xDAltimamente aqu\xED
do: sus pasos, una l\xEDnea cada uno
un texto
plano con * habitaciones
sin habitaci\xF3n
a la vez
bater\xEDa cargando
Luz y aviso cuando hay agua donde no debe.
eliminar #
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
da la clave que su configuraci\xF3n de ESPHome tiene en "api: encryption:" como key_file, o ninguna
habitaci\xF3n
se rechaz\xF3 a {issuer}: &
Tema
homebot sabe qui\xE9n est\xE1 en casa por los tel\xE9fonos de la red y los rastreadores.
fuera
De noche se encienden y apagan l\xE1mparas sin nadie en casa.
Aviso cuando la lavadora ha terminado.
su convenci\xF3n fall\xF3
reducido
, por el dispositivo o una persona
no ha dicho lo que sabe hacer desde que arranc\xF3 esta pasarela; quiz\xE1 duerma: despi\xE9rtalo, e int\xE9ntalo otra vez
guardarlo en este navegador
avisos fallidos
otro cifrado
\xBFpila, corriente, alcance? Si ya no existe: homebot forget DEVICE
secando
Estudio
Colas y p\xE9rdidas
Nada de lo medido funciona.
Lo que cambias aqu\xED se ve en todas las pantallas.
sus lamas solo se abren (100) y se cierran (0)
descartados por exceso
un n\xFAmero
este homebot no tiene rutinas
oscuro
Sin TLS el navegador no instala ninguna aplicaci\xF3n: tls = true en [door].
versi\xF3n
conexiones fallidas
robot aspirador
Colores
cifrado
valores ilegibles
una pulsaci\xF3n de su bot\xF3n
copiado
cerrar sesi\xF3n
por s\xED solo
quedan * s
nada
no hay direcci\xF3n: [notify] no tiene ninguna
configuraci\xF3n err\xF3nea
Una l\xE1mpara gana luz veinte minutos antes de levantarte.
el estado de la casa
enviado otra vez
mostrar qu\xE9 permite aprobar #
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
anuncios`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# pregunta, as\xED que responde otro: usa el token del propietario, y da a los programas el suyo
# debe preguntar por s\xED mismo
la pregunta termin\xF3: &
el servidor Matter responde con el error *
el puente para HomeKit no puede escuchar en #, puerto *: &
a\xFAn no est\xE1 vinculado; $, con el c\xF3digo impreso en \xE9l
no tiene la parte #; tiene $
< nunca baja de {least}, y no tiene interruptor
pide <; &
acepta por ciento; \xBFquer\xEDas decir < %? Para $ %: #
acepta un texto de la forma $ (*)
un n\xFAmero en $
\xBFen $? < es desconocido; da un valor, como #
no tiene habitaci\xF3n: $
# cambi\xF3 * veces en {span} s$
un reinicio perder\xEDa esto, pues no se escribi\xF3: &
# lo usa un homebot en marcha
# est\xE1 en la configuraci\xF3n; cambia all\xED [places]
hay dispositivos en ella: $; ponlos antes en otra
ninguna orden lo dio a #, que tiene <
ninguna orden dijo la habitaci\xF3n de #
no hay dispositivo #, y ninguna orden dijo su habitaci\xF3n
puede haber * con {most} partes en total; quita antes una
demasiadas pruebas: espera * s
apru\xE9balo con \`homebot approve ^\`, y {advice}
si no puede da\xF1ar a nadie, \`homebot tag add ^ #\`, si no, {advice}
la propuesta * ya no existe; \`homebot suggest\` los muestra
# no es inofensivo (&), y cambi\xF3 desde tu aprobaci\xF3n: $; apru\xE9balo con \`homebot approve ^\`
^ # no est\xE1 abierto
pon lo que su configuraci\xF3n de ESPHome tiene en "api: encryption: key:" en un archivo, y n\xF3mbralo en [gateways.mdns.drivers.esphome.devices."^"] como key_file
pon lo que su configuraci\xF3n de ESPHome tiene en "api: password:" en un archivo, y n\xF3mbralo en [gateways.mdns.drivers.esphome.devices."^"] como password_file
a\xF1ade "api: encryption:" a su configuraci\xF3n de ESPHome, o quita la clave en [gateways.mdns.drivers.esphome.devices."^"]
se anuncia en <, pero allow_plaintext_at es $; &
alguien debe aceptarlo: &
no se sabe si # est\xE1 encendido; di on u off
ning\xFAn dispositivo encaja con #; &
\xBFquer\xEDas decir #?
no se puede mandar nada cerca de #; excluido: $
no mientras {condition}: se desconoce <
acepta un texto con la forma $
acepta $ seg\xFAn ISO 8601
una orden tiene de 1 a *
debe ser un texto de * caracteres como mucho
ya hay *; retira algunas
ninguna importaci\xF3n lo indica; &
ya hay * decisiones; deshaz algunas
no tiene el anuncio #; tiene $
&; \`at_night\` (\`--night\`) lo permite
ahora alguien duerme en ~
no se cambi\xF3 nada, pues los valores anteriores no se pueden guardar: &
no hay dispositivo ni imagen #
sin conexi\xF3n en * s
no tiene la caracter\xEDstica #
no se llega a ning\xFAn dispositivo: &
otro proxy tiene su direcci\xF3n #
la interfaz # no sirve para multicast <: &
^ # no puede ser <: &
no se puede abrir ning\xFAn extremo CoAP: &
sin multicast < en la interfaz #: &
mDNS no se puede usar en #: &
no anunci\xF3 # como tema de \xF3rdenes
el broker integrado no puede escuchar: &
quiere $, y est\xE1 configurado #
quiere $, y no se admite
no cifra; &
acepta un texto de {least} a {most} caracteres
acepta un texto de * caracteres como mucho
acepta un texto de $ como mucho
su plantilla falla: $
su plantilla $
no se puede codificar como $
Home Assistant no salud\xF3 en * s
calentar\xEDa a {least} \xB0C y enfriar\xEDa a {most} \xB0C
estado HAP *
el puente de # no est\xE1 conectado
el nodo * est\xE1 en marcha, pero el gateway ya tiene max_nodes
el gateway de Matter no tiene el dispositivo #
el dispositivo responde con el estado $
el dispositivo responde con el error $
la direcci\xF3n # es desconocida: &
no se entiende el tipo de contenido #
termin\xF3 la observaci\xF3n de #
no se pueden hacer copias en #: &
acepta &, y ning\xFAn cambio
no ofrece $
no tiene el script #; una tabla [[gateways.ble.proxies]] lo instala
el robot no acepta \xF3rdenes en su modo $
una p\xE1gina no puede cambiar la tabla #, solo: $
la clave # carga un programa o un archivo; escr\xEDbela t\xFA
no puedes dar el derecho #; usa: homebot token new
ninguna copia tiene un byte *; empieza en 0
el cambio # no nombra nada
la direcci\xF3n # ya no est\xE1 en el archivo; m\xEDralo otra vez
el gateway # no est\xE1: &
# no respondi\xF3 en * s; no se sabe si lo hizo
rechazado (<): &
volvi\xF3 tras * s, <
no enviado: &
contradicho: &
ahora no se puede resolver el nombre del equipo ($)
# tiene el ascensor
< cerr\xF3 la conexi\xF3n
# no est\xE1 conectado: &
# no est\xE1 conectado
# no respondi\xF3 en * s
# duerme; int\xE9ntalo cuando despierte
# no est\xE1 disponible en Home Assistant
Home Assistant ya no tiene entidad para #
# no tiene controlador; \`homebot doctor\` nombra los que no sirven
no se conf\xEDa en el certificado de #
$: el servidor responde *, quiz\xE1 funcione m\xE1s tarde
el servidor responde *
pide una contrase\xF1a (estado *)
no deja entrar a homebot con esa contrase\xF1a (estado *)
no acepta: <
acepta un n\xFAmero de {least} a {most}
no tiene ese ajuste; acepta {list}
# no midi\xF3 ning\xFAn cambio
no hay ning\xFAn dispositivo #
no hay nadie en ~
# nunca ha detectado a nadie; pasa una vez por delante
# solo se oye desde hace * s
&, y el acceso solo permite $; a\xF1ade {right} en la tabla [{table}] de homebot.toml
&, y el acceso solo permite $
un dispositivo as\xED necesita un permiso que lo nombre (&)
$, y eso prevalece * s m\xE1s
<, seg\xFAn un aviso antiguo: ahora inaccesible
<, seg\xFAn un aviso antiguo: visto hace {age}
<, seg\xFAn un aviso guardado: a\xFAn no ha informado
# ahora se llama $
# se rechaz\xF3 y no volver\xE1
# no funciona: &
ya hay una rutina o app #; elige otro nombre, o edita esa
# est\xE1 en la configuraci\xF3n; c\xE1mbialo all\xED, y luego: $
no hay nada que deshacer: # no se aplic\xF3, o ya se deshizo
ya no queda nada de # que recuperar
ya hay una escena #
# no est\xE1 en la casa ahora; d\xE9jalo como est\xE1, o fuera
puede haber *; quita uno primero
# cambi\xF3 mientras tanto; m\xEDralo, e int\xE9ntalo de nuevo
# ya existe; elim\xEDnalo, o dale otro nombre al gateway
&, por eso solo por su nombre: $
no est\xE1 emparejado: $
# no est\xE1 emparejado con homebot
la \xFAltima recarga se rechaz\xF3: &
sin respuesta en * s
demasiados c\xF3digos sin efecto conocido de {issuer}
no mientras {condition}, y el estado de # es desconocido: &
hay alguien en ~: # estaba activo hace * s, y desde entonces no se abri\xF3 ninguna puerta
puede haber alguien en ~: # cambi\xF3 hace * s, y ninguna orden lo explica
# necesita un permiso que lo nombre (&), y {issuer} no lo tiene; {advice}
# necesita un permiso, porque &, y {issuer} no lo tiene; {advice}
no est\xE1 en la lista de dispositivos inofensivos ($)
mantenido en < por {holder} hasta que se libere
mantenido en < por {holder} * s m\xE1s
mantenido por {holder} hasta que se libere: <
mantenido por {holder} * s m\xE1s: <
# dijo que no
nadie respondi\xF3 en * s: se hace en la p\xE1gina o con \`homebot answer\`
son las >, y hay silencio de {start} a {end}
hay alguien en ~: $
hab\xEDa alguien en ~ hace * s: $
puede haber alguien en ~: $
no se sabe si hay alguien en ~: &
no mientras {condition}: $
el miembro # lo rechaza: &
{issuer} no puede controlar #, solo: $
{issuer} no puede controlar #: &
no se puede contactar con ning\xFAn dispositivo: &
no se puede contactar con #: &
# no est\xE1 en la red ahora
se perdi\xF3 la conexi\xF3n con #
tipo: <
tipo: <
se llama #
su unidad es #
calienta hasta * \xB0C
junto a otra parte: &
el nombre # dice $
el modelo # dice $
la pasarela # no dice su estado
problema de #
abandonado por #
fallos en # desde el inicio
contado por # en los \xFAltimos diez minutos
contado por # desde el inicio
en cuarentena en #, que solo lee una parte de sus mensajes
nota sobre #
pasarela #: <, env\xEDa \xF3rdenes
pasarela #: <, solo observa: &
pasarela #: <, solo observa
pasarela #: <: &
& Tras reiniciar homebot: {keys}
El archivo no ha cambiado: &
* dispositivos esperan aprobaci\xF3n y no reciben nada antes: {list}
1 dispositivo espera aprobaci\xF3n y no recibe nada antes: {list}
el \xFAltimo mensaje no se envi\xF3: &
visto hace {age}
hecho: $
omitido: no $
$ fall\xF3: &
< (* %)
<, desde hace {age}
# no es seguro (&), y <; apru\xE9balo con \`homebot approve ^\`
la regla fall\xF3: $
* \xF3rdenes esperan su resultado
su pasarela # est\xE1 <: &
su pasarela # est\xE1 <
# no respondi\xF3 en * s: $
nadie escucha $
su bot\xF3n no se puls\xF3 en * s; p\xFAlsalo e int\xE9ntalo otra vez
# no se vincul\xF3: &
$ se rechaz\xF3: &
# no tiene imagen
^: # no vio efecto de su \xFAltima orden; una vez reparado, \`homebot trust $\`
acepta: &
esta parte acepta: {list}
ninguno de sus modos: {list}
el dispositivo responde: &
# ya est\xE1 vinculado con homebot
# depende del puente $, que se vincula entero
&; otra vez en * s
desde aqu\xED, solo: <
ya hay una habitaci\xF3n #
# ya se llama as\xED
# est\xE1 vinculado con otro sistema; qu\xEDtalo all\xED o restabl\xE9celo, luego $
# se elimin\xF3
# se cambi\xF3
# se a\xF1adi\xF3
# dijo que s\xED
# no responde
# no respondi\xF3
# no acepta \xF3rdenes que homebot conozca
* dispositivos encajan con #; como mucho {most} a la vez
$ no se envi\xF3 a #: &
$ se envi\xF3 a #: &
$ de #: &
# ya tiene $
# no tiene ninguna parte
no se llega a # con TLS: &
ya hay * proxies Bluetooth conectados
# tarda m\xE1s de * s en responder
# no se conoce en ning\xFAn extremo
# no tiene direcci\xF3n HTTP
# no tiene direcci\xF3n
# no responde a peticiones
# no acepta mensajes
# termin\xF3 los eventos
# no se puede anunciar como $: &
#: * \xF3rdenes esperan ya a $
# no se puede abrir: &
# no se ajust\xF3: &
# se empareja con el c\xF3digo que lleva: $
# ya est\xE1 puesto en marcha
# est\xE1 tras el puente $ (^); solo se puede quitar el puente
# no responde al servidor de Matter
# a\xFAn no se ha descrito
no se puede ajustar $ de #
no se puede escribir #: &
no se puede apartar #: &
no se puede copiar #: &
# de $ no cabe en un archivo propio
# = $ no es un valor de TOML; los textos llevan comillas
# no puede ser un nombre: da hasta * caracteres imprimibles
# falla ($): &
son las >, y se duerme de {start} a {end}
\`$ --act ^\` da uno
$ act = [^] da uno
# en $: &
$ en pasos de *
$ segundos o m\xE1s
de {least} a {most} s
# (&)
no hay < #; &`;export{n as reasons,e as texts};
