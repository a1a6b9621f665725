var e=`12j 1nt xg kp 7jj e9 1ca 7b 6gn o4 1jy 16u 187 3l 43 1ys dl 2gl 9k l 16l dy 1tl mb 18g 1 2g jv ht 1ey b2g 2o9 57v 56 77i 19j 2ce eq 2dy f9 2u5 25s 6sh 2u 34u ds 6z 8u 1ck 15z dw fw tk 9a 3z9 dz 2d 2re 1sy 26q 4il 5th 9s 28y f4 fs 2do afh 8f 3i5 cv 61l 2hu 1 yw 2so 21l qk 1pk f8 49v h0 2nv 50y 1ws 50y 2qv sp qi 1p8 16f qf cf sm 8r ds 1m5 fv 6a 4pw 2p6 143 1bj 2ur 1px 3lz cz 18x 1x9 3eg 2dx 7on 1cp 3c 34y 11h 169 eh df da 8ls 1q9 x4 3xe 14o c7w 3ah 5z 5k 32g s0 l7 9fy 1xr 44j 27j ta g3 ep qk 6mh 12p 1og 1xv 15x 49 el 23l 328 5i 100 327 1wm 1xk 1ap 2t4 2v1 5x 2k 4s 2h8 1kc 2g6 2i9 2no r4 6rc 1v6 1q0 i9 32t 1av 42x xs 13 kd 112 3bm 1n4 1e2 b2 p6 1i3 wv 1w6 3qg 175 3jk g7 41r 2g7 3il 1pz 2g1 ro 3wh 1qt 26e oz 3rr 1tg 1c f3 6yx al 4so 17l 41w 6dv 1kc 1nd cu 1rj 7fv 59c 140 1be 3cm dw 4go 1li zh 4yb 68y c2 5d0 31 2er 3sa 43i 1kz 34i 4w8 13r 22m ak9 2ou 1q1 6gs 2nw v4 hm 3in ay dx 54a 8ph 8yp 1n2 226 5j4 3kr 8p c9 1ax 4x xt 2z1 2b9 1lj 7q3 8ma 7vl cel 24 5el xa mf 3wt 3xk 2qm 6vi hx 6bj 6o 4on byf 4ut t9 2h 405 2ht 1x7 1pt 1eb 4zo 6rz 9yz 53o a8 ow 1cc 3gv 3ej 7a 3r 226 ub 9jc 1v 2cw 8b p9 17l 149 13y 59b 2bs 3pw 1sj 5ho 1ho 17t 8mb fn 2jv rf c0p 2s 14d hy 2nz 1gt r4 1qs 31i 2z9 klp 18a 207 tj tg 3q 3g 2bl ji c 2s9 4x6 6xf 11b 14h 2e8 emi 2tj cz yw 1tn aa 34y 4ut 2y0 1y 2tz gr 2ny 60j 3jv 1nb th 1ew 5jo 7z 1pz 6mz 2pe 2mr tx 1ce 7d7 44g 1w8 x 2fx 11r a9 2m1 4ci 133 9l 72c 6i vc 5um nr 2dc 483 pv 3s 7gs e5 308 l6 447 ui 23k 233 1fi ca lq 2ct vi 23l bq 1ds z0 d6 31k 3ca 4i2 k2 4sq 2g3 1vq 3oz 2a8 26q 341 1r9 28q 344 3d0 1lc 28 13 3je oz z7 206 2gi cj x9 8u 4k5 2pp 7t 37h 3kx rh 2nq 84j 1cx 1bw 4sv 3y 4dy ox 1jt 1dk 1d0 1h 46 4ig r7 392 132 3ok 27c 33y 7j 3ql z4 1tg bg 303 11 28r 1tv 3e 976 6e4 40v bmc 1xq zn 5sd 4so 3u 5lg 38 4j1 3tr 13q 350 8xl 15c 1o8 18z 4m3 af jf 3yp 2vr 2q3 sw 176 7y f 2f4 14r 18b 27i 1q7 56i 2k2 38y 5g3 2s9 lu 1xh xr we 4f6 1ox r 179 ed6 18o 1lc 9r 1 2nd bd 59v 3yl 3zn o 13q 23e ij 9xx gb qp bu to 2ub a1g 11h 1b4 1p3 1cl 40g 1f3 7n3 32e zz ha 1sv 3h6 1pm 2gp 1kl 3qy 1f2 3qi 2d3 23v 5ta 5p 31l 2qw 9nh 5n 39d 28q 16x 3fr 58u 1e3 aa 2c 1h 38r y ep 5tz 3it pv q4 tn k3 18d akw 1ki 1kq 5on is 1nx 16s 19d 3f 2hr 3fi 5up 2zs 2m7 82 3pd 20r 3x7 6f 3lr 5j1 w3 171 kp h 1nr 8ry 16b 17q 42u vd 3po 11x z 26y 9x0 5jo l2 24d 4aw bm 6y 4et 125 35n 1ta 71r 1c5 2y 2f b8 27u 113 4rf 4f5 958 2el 1n7 2d4 32f 7wy 73a 1l1 3ly 4dj 8jf 4n fb 1ua 18k xh
no respondi\xF3 a tiempo
Garaje
Jard\xEDn
detecta manipulaci\xF3n
configuraci\xF3n err\xF3nea
pasarela
detector de fugas
Siete d\xEDas
A\xF1adir
el robot tiene una orden; pon antes su opci\xF3n en idle
homebot funciona de prueba y no env\xEDa nada
Registro
PM1
la tabla de un gateway tiene secretos, ninguna p\xE1gina la lee
\xD3rdenes
Por qu\xE9
el broker ya no responde
cerrar sesi\xF3n
consulta
fallos del archivo de dispositivos
\xFAltimas veces
si empieza mientras se ejecuta
baja
ahora
se ejecut\xF3
en bruto
hazla tuya o indica otra en HOMEBOT_DATA
etiqueta
\xBFHay fuego? Salid y llamad a los bomberos
inform\xF3 {values}
accesible por
si homebot ya funciona, preg\xFAntale: homebot doctor
no hay ruta a ese equipo
when: lo que la inicia, una l\xEDnea cada uno
preajuste
ning\xFAn programa responde all\xED: in\xEDcialo, o corrige la direcci\xF3n
deshacer
humedad del suelo
atr\xE1s
antes
uno de sus valores es desconocido
sensor de lluvia
se ha activado
quiere varios a la vez, y no se admite
Hoy
desde >
secando
normal
Token
la habitaci\xF3n del dispositivo
Tema
retraso del bucle de eventos
Idioma
Necesita: $
informes
anuncios rechazados
pila baja
vuelve a instalar el homebot m\xE1s nuevo, o: homebot restore BACKUP
Las nuevas pasarelas empiezan con el pr\xF3ximo inicio de homebot.
aspiradoras que a\xFAn no son robots
est\xE1 ocupado
hacer una copia
usar #
{issuer} public\xF3 {text}
un puente no tiene c\xF3digo: pulsa su bot\xF3n
c\xE1mbiala o c\xE1rgala
no se conoce la habitaci\xF3n del dispositivo, as\xED que puede haber alguien
humo o calor
da uno, como level 40
Lo dice un mensaje guardado, sin decir desde cu\xE1ndo.
Ya est\xE1 en vigor.
Personas
ocultar
alta
tiene la etiqueta always_ask
el estado de la casa
con retraso de
acepta una fecha sin zona horaria
Est\xE1 as\xED desde que homebot lo conoce.
detector de heladas
la red lo acept\xF3
Longitud
por s\xED solo
Un token da a esta p\xE1gina sus permisos: el tuyo es la l\xEDnea de owner.token, en la carpeta de datos de homebot. Para una tableta, crea uno con:
hogar
Cargando el plano \u2026
robot
Omitidos por ser secretos: {files}
anuncios rechazados
Como ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com los enumera todos.
, por otro programa
no se uni\xF3 nada a \xE9l
fallos del diario
por otro programa
conexiones fallidas
fabricante
descartados por largos
homebot why DISPOSITIVO muestra los informes
Terraza
acepta n\xFAmeros de 0 a 360, 0 a 100
homebot sabe qui\xE9n est\xE1 en casa por los tel\xE9fonos de la red y los rastreadores.
hace >
horas de silencio
{least} a {most}
Guarda los valores actuales de:
modo
est\xE1 mojado
anuncios
acepta true o false
modo del ventilador
pr\xF3xima vez
La casa est\xE1 abierta
mostrar qu\xE9 permite aprobar #
if: todo lo que debe cumplirse entonces
aire acondicionado
no se envi\xF3
por {issuer}
Esto est\xE1 ahora en homebot.toml:
Nombre y lugar
Los nodos de la izquierda publican temas, los de la derecha se suscriben.
no se conoce el nombre del equipo: corrige la direcci\xF3n
inicios de sesi\xF3n fallidos
parada
Planta baja
topics rechazados
planta
usa un directorio en este equipo, o configura su direcci\xF3n
Historial
cada vez
sensor de apertura
direcciones rechazadas
ci\xE9rralo
acepta una fecha de 1970 a 2106
est\xE1 en la configuraci\xF3n; cambia [places] all\xED
modo
sin conexi\xF3n
Tel\xE9fono en la red
di\xF3xido de carbono
ocultarlo en la casa
Abrid las ventanas, salid y pedid ayuda
solo acepta true
acaba de anunciar otros temas de \xF3rdenes, quiz\xE1 de otro dispositivo; int\xE9ntalo otra vez
Esta pantalla
{nodes} nodos y {topics} temas
Direcci\xF3n
temperatura de color
tipos rechazados
localizador
sus lamas solo se abren (100) y se cierran (0)
$ a lo largo del tiempo, * puntos
compuestos org\xE1nicos vol\xE1tiles
no disponible
no le queda memoria
visto por \xFAltima vez
ese modo no tiene esa consigna
copiado
vincular
anuncios: bytes de m\xE1s
no hay nada que deshacer, o el archivo cambi\xF3 despu\xE9s
recreado
no hacer nada
su plantilla no da nada para ello
no tiene sensor de movimiento
homebot busca en el historial de cuatro semanas lo que haces una y otra vez, y lo observa una semana antes de proponerlo.
homebot show DISPOSITIVO
a\xFAn no ha informado de nada desde que arranc\xF3 homebot
los emparejamientos con Apple Home
Ni llamas ni interruptores; abrid las ventanas, salid y pedid ayuda
nueva rutina
persiana o cortina
A\xFAn no hay cerradura, contacto ni alarma.
plano con * habitaciones
un n\xFAmero
Zona horaria
Cada pantalla tiene su propio token, que se le puede quitar.
Sus dispositivos aparecen aqu\xED.
cuarentenas
no acepta ninguno
presi\xF3n
ajuste
en marcha
Esta imagen ya no es reciente.
Un servidor en este ordenador
Un dispositivo sin valor queda fuera.
espera, un minuto como mucho, a los dispositivos de antes; int\xE9ntalo otra vez
guardarlo en este navegador
no tiene orden que seguir; dale un destino
dispositivos rechazados
dejar que esta rutina maneje {names}
sensor de calidad del aire
Tus costumbres
se perdi\xF3 la conexi\xF3n con Home Assistant
Las alertas y preguntas llegan por estas direcciones a tel\xE9fonos, chats y correo.
no anunci\xF3 ninguna
el dispositivo responde con un error
el robot a\xFAn no ha dicho su estado
mensajes por segundo
la direcci\xF3n de un flujo, como una radio
pulsador
Su \xFAltimo suceso, que no es un estado:
\xF3rdenes fallidas
\xDAltimamente aqu\xED
guardado
detector de humo o CO
sensor de caudal
anuncios: bytes en memoria
intensidad de se\xF1al
siguiente
localizar
homebot no puede reiniciarse solo aqu\xED; in\xEDcialo de nuevo
Humo, agua, movimiento
un n\xFAmero finito
modelo
ninguna direcci\xF3n
valores rechazados
A\xFAn no ha pasado nada.
respuestas
varios nombres para un identificador: quiz\xE1 varios dispositivos
{issuer} pidi\xF3 {values}
\xBFEst\xE1 abierta la carcasa, o fuera de la pared?
la conexi\xF3n se cerr\xF3
su puente no lo alcanza
cortac\xE9sped
Cambi\xF3 a las >.
detector
el dispositivo solo emite
No entendido a las >:
disyuntor
sensor de luz
Pulsa el bot\xF3n del dispositivo y luego \xABvincular\xBB.
el registro y homebot journal dicen m\xE1s
da a homebot una carpeta donde pueda escribir (HOMEBOT_DATA), o arr\xE1ncalo con --ephemeral
sensor de humedad
enviado en un solo mensaje al grupo #
todo
sensor de presi\xF3n
Apps
Home Assistant cerr\xF3 la conexi\xF3n
Ning\xFAn dispositivo indica a\xFAn su potencia o energ\xEDa.
clientes cortados
a\xFAn sin conexi\xF3n
v\xE1lvula de agua
tras un c\xF3digo incorrecto necesita una pausa; int\xE9ntalo m\xE1s tarde
bluetoothd no est\xE1 en marcha
no se sabe: {names}
nadie se enter\xF3; [notify] y el registro dicen por qu\xE9
actualizaci\xF3n
Todo est\xE1 bien.
A los cinco minutos muestra un reloj tenue y lo que est\xE1 abierto. La direcci\xF3n de esta pantalla:
enviado en un solo mensaje a la escena #
calentador de agua
presencia
reiniciar #
rechazar
deshacer
velocidad
central de alarma
medidor el\xE9ctrico
Qu\xE9 se sabe, y de d\xF3nde
otra clave
Estudio
Sin medidor propio
ninguna orden manda a la gente a casa
pon password_file o password_env en [gateways.mdns.drivers.shelly]
grafo
No hay nada que proponer.
No hay (o ya no hay) un dispositivo #.
frecuencia
el dispositivo ya no tiene esa parte
# est\xE1 vinculado.
Calienta con una ventana abierta
Cambiado desde la aprobaci\xF3n anterior:
do: sus pasos, una l\xEDnea cada uno
no es un puente Hue; empareja el puente al que pertenece
suscripciones rechazadas
env\xEDa lo que su anuncio no explica
\xFAltima versi\xF3n
{energy} devueltos
donde est\xE1 esta pantalla
cu\xE1ndo
la pasarela solo observa; perm\xEDtele dar \xF3rdenes en Sistema, Dispositivos
Sin TLS el navegador no instala ninguna aplicaci\xF3n: tls = true en [door].
homebot funciona sin archivo; in\xEDcialo en una carpeta con homebot.toml
No se guarda nada de ese tiempo.
cerradura
crear un token
no lo hiciste
Cargando las rutinas \u2026
HomeKit no tiene servicio para ello
topics reservados
progreso de la actualizaci\xF3n
a\xFAn no se cambi\xF3 nada
da la clave que su configuraci\xF3n de ESPHome tiene en "api: encryption:" como key_file, o ninguna
Espera tu aprobaci\xF3n
sin respuesta
Copia de seguridad
El c\xF3digo del dispositivo
Mostrar
ninguna escena guarda uno
Home Assistant lo rechaza, o el c\xF3digo es incorrecto
nombra un dispositivo, o busca como 'light in hall'
hacer
Alertas
peticiones rechazadas
reproductor de v\xEDdeo
recibidos
Ninguna habitaci\xF3n tiene forma a\xFAn. Dale esquinas en la tabla [places.rooms], o importa un mapa: homebot places import ARCHIVO.
da a cada dispositivo un identificador propio en sus anuncios; mientras, sus partes tienen estos nombres
el c\xF3digo es incorrecto
buscando \u2026
no acepta \xF3rdenes; solo informa
una escena tiene valores que duran; para lo que se hace una vez usa una rutina
inofensivo
no hay D-Bus; en Linux, bluetoothd y el bus del sistema deben estar en marcha
cada paso
contradicci\xF3n
respuestas desconocidas
no hay v\xEDa para \xF3rdenes
usuario
demasiados c\xF3digos incorrectos; descon\xE9ctalo un momento
puerto
Energ\xEDa por d\xEDa
horas y la casa
encontrados y a\xFAn sin usar
No hay ninguna app en marcha.
enviado otra vez
su plantilla falla con este c\xF3digo
Cargando el grafo \u2026
mensajes perdidos
empezar de nuevo
no se puede observar
un programa desconocido
Dispositivos
archivo de datos
sobre todo #
frecuencia
cambiar
on u off
solo responde una persona, en la p\xE1gina
el dispositivo est\xE1 en servicio, pero no se pudieron leer sus atributos
se est\xE1 vinculando otro dispositivo
no se encontr\xF3 ning\xFAn dispositivo con este c\xF3digo; \xBFest\xE1 listo para vincularse, en esta red y a\xFAn sin vincular?
anuncios derivados
se contradicen; da solo uno
homebot show DEVICE muestra ambos lados; homebot forget DEVICE lo termina
Pasillo
medios
cierra el agua
no se puede contactar con \xE9l
el dispositivo solo puede apagarse, como una placa por seguridad
sin ruta a esa red
otra contrase\xF1a
las \xFAltimas 24 horas
Preguntando a homebot \u2026
A\xFAn no se ha contado nada.
lleva demasiado tiempo en silencio
demasiado largos
se cancel\xF3
sensor de temperatura
tiene poca bater\xEDa
el control no est\xE1 en marcha; se reinicia solo, v\xE9ase Sistema
\xBFpila, corriente, alcance?
rechazados
Colores
limpiar habitaciones
acepta una fecha con zona horaria
ha cambiado desde entonces; m\xEDralo otra vez
solo una app o una rutina puede tener uno, por su clave \`act\`
ya no llegan eventos
energ\xEDa del {day}
anuncios ignorados
el termostato est\xE1 en otro modo; c\xE1mbialo primero
Nombre
True o False
inaccesible
su convenci\xF3n fall\xF3
aqu\xED no
Latitud
oscilaci\xF3n
lo hiciste > despu\xE9s
Se est\xE1 haciendo \u2026
homebot place DISPOSITIVO HABITACI\xD3N
Diagn\xF3stico
buscar costumbres
C\xF3digo QR
Ahora
permitido
sin dar motivo
corregirla y luego: homebot config check
bater\xEDa cargando
reinicia homebot tras una tabla nueva: docs/protocols.md
a la casa
Puertas y ventanas
Receptor m\xE1s lento
Colas y p\xE9rdidas
se apag\xF3 el servidor de Matter
Ya estaba as\xED en su primer informe.
esa pregunta ya no existe; \`homebot answer\` muestra las abiertas
observa: #
a\xF1ade la tabla y reinicia homebot: docs/robots.md
detecta humo o calor
, por s\xED mismo
Persona
conservar
todos en casa
Ning\xFAn dispositivo indica a\xFAn una temperatura.
una contrase\xF1a
Etiquetas
avisos fallidos
Temas m\xE1s activos
fuga de agua
despu\xE9s
el servidor de Matter es demasiado lento
el directorio a\xFAn no se ha le\xEDdo
espera un minuto y mira el registro de homebot
caducidades descartadas
avisos descartados
descartados por mal formados
Mensajes
el robot no sabe d\xF3nde est\xE1; local\xEDzalo primero
otro cifrado
sensor
una habitaci\xF3n nueva
el cliente #
no ha dicho lo que sabe hacer desde que arranc\xF3 esta pasarela; quiz\xE1 duerma: despi\xE9rtalo, e int\xE9ntalo otra vez
tard\xF3 demasiado
Contiene todo lo que homebot guarda, menos las contrase\xF1as.
favorito
en reposo
imagen
infractores olvidados
sabotaje
# puede controlar dispositivos
propuesta por #
aprobaci\xF3n
estados perdidos
Pantallas
En la semana de prueba lo hiciste {done} de {total} veces; una rutina acertar\xEDa entre el {low} y el {high} % de las veces.
acepta m\xE1s de 0 y hasta 100 %
abierto mucho tiempo
su otra consigna es desconocida, y ambas van juntas
, por el dispositivo o una persona
permisos
acci\xF3n
, un eco
, por una persona
no es un JPEG, PNG, GIF o WebP de hasta 2 MiB
mensajes en espera y perdidos
no se sabe nada que una escena pueda recuperar
su gateway codifica sus mensajes
cambi\xF3 a {values}
ejecutar ahora
Un punto lleno est\xE1 encendido, abierto u ocupado.
el broker
ha cambiado desde tu aprobaci\xF3n
modo
en espera
ajustar
mon\xF3xido de carbono
identificadores cortados
humidificador
su modo es desconocido; aj\xFAstalo primero
La casa est\xE1 cerrada
Todo est\xE1 bien. A tener en cuenta:
una contrase\xF1a sola ir\xEDa sin cifrar a quien se llame as\xED: a\xF1ade "api: encryption:" a su configuraci\xF3n de ESPHome y da key_file, o su direcci\xF3n IP fija como allow_plaintext_at en [gateways.mdns.drivers.esphome.devices.NAME]
una pulsaci\xF3n de su bot\xF3n
robot aspirador
est\xE1 abierto
avisos perdidos
este homebot no guarda nada
En una pared
desconocido ahora
Ocultos
sin anuncio v\xE1lido desde que arranc\xF3 esta pasarela; reinicia el dispositivo o su puente, o espera
El lugar da el amanecer y el atardecer; se queda aqu\xED.
Abre esto una vez en la pantalla; solo se muestra ahora:
Los primeros valores llegan en dos segundos.
seguir sin token
el c\xF3digo es incorrecto; si est\xE1s seguro, int\xE9ntalo otra vez
since debe ir antes de until
secreto
no hay direcci\xF3n: [notify] no tiene ninguna
Token o c\xF3digo
Cada dispositivo tiene una habitaci\xF3n.
empieza por {view}
Rutinas listas
\`homebot find\` muestra lo que sirve
Lo que cambias aqu\xED se ve en todas las pantallas.
El c\xF3digo que muestra homebot run deja entrar a la primera pantalla.
caudal
CoAP no tiene ese m\xE9todo
Puede
en disputa
, porque {device} inform\xF3 {values}
detecta mon\xF3xido de carbono
anuncios ambiguos
falta una biblioteca
el texto
anuncios aplazados
conexi\xF3n
no se puede codificar como UTF-8
En la app Casa: +, A\xF1adir accesorio, y escanea esto o escribe el c\xF3digo.
corrige o quita el emisor
este protocolo no acepta \xF3rdenes en bruto; usa una direcci\xF3n de texto
rutinas listas
fallos
Emparejado con * controladores.
tono (0 a 360) y saturaci\xF3n (0 a 100), como 0,100 para rojo o 240,50 para azul p\xE1lido
Nada de lo medido funciona.
enviando \u2026
como el sistema
las etiquetas no aceptan \xF3rdenes
novedades perdidas
conexiones rechazadas
\u2026 y * m\xE1s
est\xE1 vinculado en otro sitio; qu\xEDtalo all\xED o restabl\xE9celo
fuga de agua
ascensor
, en camino
mirar
perdidos
darle el derecho
Nombre, habitaci\xF3n y etiquetas
Usuario
valores
el perfil del dispositivo no tiene trama para ello
Ninguna de las * entradas m\xE1s recientes tiene esas palabras.
un texto
Dormitorio
Lo que guarda esta escena no dice sus valores.
fuera de todas las habitaciones
se anunci\xF3 despu\xE9s de aprobar el dispositivo
temperatura ambiente
A\xFAn no hay ninguna rutina.
enclavamiento
Ba\xF1o
respuestas tard\xEDas
preguntar siempre
consultas descartadas
si
Las l\xEDneas aparecen aqu\xED seg\xFAn llegan.
sensor de presencia
no tiene direcci\xF3n
este homebot no tiene rutinas
corr\xEDgelo seg\xFAn el registro: homebot app reload APP, homebot gateway restart NAME
no tiene
claro
a mano o por s\xED solo
# se ha descargado ({size} kB).
, porque se deshizo la escena {scene}
mensajes no guardados
Cocina
oscilaci\xF3n horizontal
A\xFAn no ha informado de ning\xFAn cambio.
Qui\xE9n la usa ahora
el propietario no lo ha aprobado
Bucle de eventos
Valores, historial, datos
Valores
mirar y actuar
se perdi\xF3 la conexi\xF3n
descartados por exceso
cifrado
carpeta de datos
necesita un c\xF3digo
acepta habitaciones, pero a\xFAn no ha nombrado ninguna
energ\xEDa devuelta
el broker integrado no puede escuchar: todos los puertos est\xE1n ocupados
desarma la alarma
calefactor
Para restaurarla:
tono de sirena
quedan * s
t\xEDtulo
S\xF3tano
a\xFAn no se conocen los dispositivos de la casa
, porque se aplic\xF3 la escena {scene}
habitaci\xF3n
eliminar #
fuera
rechaza la contrase\xF1a de password_file o password_env en [gateways.mdns.drivers.shelly]
sensor de suelo
activa
hace la casa m\xE1s segura
a mano
no est\xE1 entre lo que el acceso puede controlar
tomar los valores actuales
descartados por lectura lenta
corrige el dispositivo o su anuncio
deben ser segundos, 0 o m\xE1s
las m\xE1s recientes primero
Encontrados:
calidad del aire
un c\xF3digo Matter tiene 11 o 21 cifras, o es un c\xF3digo QR que empieza por MT:
el historial no ha empezado, o no se guarda; \`homebot doctor\` dice por qu\xE9
\xBFpila, corriente, alcance? Si ya no existe: homebot forget DEVICE
, por $
solo la tabla de un gateway acepta contrase\xF1a o token
acepta un n\xFAmero que su formato pueda expresar
puede manejar
El mensaje de prueba se ha enviado.
lo hiciste > antes
PM10
El certificado en el que deben confiar sus dispositivos
lector de etiquetas
no existe ese dispositivo
A\xFAn no hay ning\xFAn dispositivo.
el servidor de Matter no tiene Bluetooth; solo llega a los dispositivos de la red
plano con * habitaci\xF3n
se rechaz\xF3 a {issuer}: &
el puente responde algo desconocido
Sal\xF3n
{energy} kWh en otros d\xEDas como este
aceptar
M\xE1s controles
el registro tiene cada uno con su traza: comun\xEDcalo o corr\xEDgelo
Contrase\xF1a
oscuro
aprobar #
descartados para ausentes
redirige a otro equipo, y eso no se sigue
a la vez
iniciar sesi\xF3n
descartados (QoS 0)
\xF3rdenes
su efecto no dura
reiniciar homebot
detecta gas
Pulsa ahora el bot\xF3n: quedan * s
nada
artista
quiz\xE1 la puerta est\xE9 abierta
se hace una vez y no dura
no es un proxy Bluetooth; a\xF1ade "bluetooth_proxy:" a su configuraci\xF3n de ESPHome
sin habitaci\xF3n
descartados por grandes
\xF3rdenes rechazadas
versi\xF3n
La aprobaci\xF3n permite estas \xF3rdenes:
t\xFA, por $
mensajes rechazados
valores ilegibles
imagen de #
enviar un mensaje de prueba
redirige demasiadas veces
indica un problema
Ning\xFAn dispositivo de esta casa sirve: $
escribiendo \u2026
el token ya no vale, o es de otro
hacen falta dos dispositivos distintos
guardar
enviado
mostrar`,n=`# asks, so another answers: use the owner's token, and give programs their own
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
# was switched back and forth * times within {span} s
# was switched back and forth * times within {span} s; with a token (\`homebot token new\`) a program may more often
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
the ^ # cannot be opened: &
the ^ # cannot be <: &
no CoAP endpoint can be opened: &
no < multicast on the interface #: &
mDNS cannot be used on #: &
$ of [#] is for the address that is there; give it again with the other one
$ of [#] names a secret of this computer; only a person writes it into the file
it is longer than * characters
the embedded broker cannot listen: port * is taken
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
gateway # starts again
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
the robot # is on its way in ~ or to it
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
it crashed ({error}) and starts again in >; at once: {text}
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
# cambi\xF3 * veces en {span} s
# cambi\xF3 * veces en {span} s; con un token (\`homebot token new\`) un programa puede m\xE1s veces
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
^ # no se puede abrir: &
^ # no puede ser <: &
no se puede abrir ning\xFAn extremo CoAP: &
sin multicast < en la interfaz #: &
mDNS no se puede usar en #: &
$ de [#] es para la direcci\xF3n actual; dalo otra vez con la nueva
$ de [#] nombra un secreto de este equipo; solo una persona lo escribe en el archivo
supera los * caracteres
el broker integrado no puede escuchar: el puerto * est\xE1 ocupado
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
la pasarela # se reinicia
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
el robot # circula por ~ o va all\xED
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
se cay\xF3 ({error}) y se reinicia en >; ya mismo: {text}
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
