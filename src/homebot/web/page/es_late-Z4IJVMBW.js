var n=`4w2yoNyHmVAl09JSb1NUOOirW8plFHRXtoNfHkuybiocTfoahynbfyP1GPQaNnRXZCvyxccMMyvPypvwg76kJp2QMy4SOPRECIhCpzXzfbx4T80oh8Zuu9YiPab6ybBLWagnQQfpzBOax2M8kz7jw8RDnvVACvROUyfaDvvrm3QJ48RzFkJQnR119wIOs8mtfKz045Jq8LKvOWOIPSPADpsKsnpVxtadOknuuLFl08uANUYifxMX57yxIVrRAgNjakuUPlXUJRz229N4h7YiSrl0ucJNAsLrF72Cy7TQOBodiB6wv9HbtJlBaY8WMk0dRFCV5wgN4LMOviw7mUsPfTjPSAnDM760XnVNoC1pLb2iNuk3JilUxTWUlKxgMtGnQMUwOMF4X4rnqr3K8uAXwt6oMchLyFuQmG2zxWv3TSozKzjfJJ20IkflBhAZAQMEonNJFALraLUVaBRQv7Pm17tJlbfXOgOYKIcca5aoUFqVYPLYzfJ9H7p100c7j5s0F6vSx7pVpsb8tyLBlYVsYZYdefNfeQJ5BDnOrdCuPG9tJAAa2PIky57Bpq6PNgqWfvADAPXkYaSp3VyzgubmDqTrJlSMApfmWMy35Dko0jQDW85dT9beSDrK0BN65ziwEBbuFBiSdpcMIVfHr6HQx8vMAacS0rDCuaL26wCylUAQ2PWpkIJYpBGu7qrDCIITmKuCUxpQVkhGFzHNxugHA8mehzaMmx49gB8hAXyZZyqsepVeDS7c2pPHzrrjQ1Tfnrz8X5lg8plp005MWaYBEoLcU9ezCgQZLI47Q3gKy9Iz7zeWgV97tgFTNtYz1rEaUoKT3JPvocErs8fC0Cpi0FAdXe6Qn4EuNu7fHnzKLioPIRIOQhvGVnAKufCzBt7eh8urvvu9TAhtlVMHTVJFYXrVlfMW9ShxcFmPP4lh8M7JW5K8Cz6IqozuA5ASXGKKJ1bvFTYKEHOYYBwzgCwfwbQb7HLWJNroAqvAttjuu6B3Qg7pHKPF9G37m50QyWmDlhql4zhwWl6NIrjSeE9dV7yTp5PaQSLmaY2iaExHUlJMcm6fMqU3X3xKoKtlbT8T2tnb69haSy8fr9fQTh0FPRxg3EnWIJYjeK3flG4EXUkBt5InRFBykHFGlrT2Wa4oX5v11QgBySOYEefEjmDKVm4ne1UldSlWYyLQ4F4JndG3tq0yHIWDEDTkWNZdqwdOB6NI034RE0eOA825ALtFLdVfuNROVdQKyYhtIGkM7YGrw7UATucq2PfSpUfwx2NLPDlsWbu0oTMLhhw3zqewGbamRhDn44uAxM1vBzE9NnMUuZNMAhb36mpYEumh6lyKXzeqs9fChC2Df0UI7WMkGz476UKewHsGHbrB91oWe6oetmWXtSMG7f4JUJDjQ0M3EDHWnjgDKdnBdMavDxB0RJEgHKOUMkq6mYTAtk37gXpzWZX6LvccJYBW7hxVYC5ZzCm4Wv0PdU2ikP3LuihkUd1Y2Y1rvoXNxxzeIVBVDY3ZFOjovy1eQbJDnildfmZpCOOzSyiqGPAiE6Iv549Uc0zMQn1kdr5E4BtLy0S1wSC1lHnPBOc9tMBTvw2ucf4oRBpIaMtghXUutHTUwYhQkd7ktG2j0qbN8NHnIc7udk3WY9kWWUJ4WTONgrnQ2ZSaHyuGCMWB3WMHk3VjXHf6LVEW8QLGbEweWRkqwMRw91VUByDy3zqCuIby2wKxezVIwZuTlY6KHNpbDQGDUdYTLMQFfAzaEzDmFmTb7xqKIM
Lo que cambias aqu\xED se ve en todas las pantallas.
deshacer
antes
aqu\xED no
ocultar
Ocultos
iniciar sesi\xF3n
cerrar sesi\xF3n
En una pared
empieza por {view}
en reposo
A los cinco minutos muestra un reloj tenue y lo que est\xE1 abierto. La direcci\xF3n de esta pantalla:
Sin TLS el navegador no instala ninguna aplicaci\xF3n: tls = true en [door].
El certificado en el que deben confiar sus dispositivos
Idioma
Un token da a esta p\xE1gina sus permisos: el tuyo es la l\xEDnea de owner.token, en la carpeta de datos de homebot. Para una tableta, crea uno con:
Token
guardarlo en este navegador
seguir sin token
ajustar
{least} a {most}
Nombre
Etiquetas
Nombre, habitaci\xF3n y etiquetas
una habitaci\xF3n nueva
ocultarlo en la casa
guardar
guardado
Sin medidor propio
No hay (o ya no hay) un dispositivo {name}.
Valores
desde {time}
\xD3rdenes
Por qu\xE9
Su \xFAltimo suceso, que no es un estado:
A\xFAn no ha informado de ning\xFAn cambio.
Est\xE1 as\xED desde que homebot lo conoce.
Lo dice un mensaje guardado, sin decir desde cu\xE1ndo.
Ya estaba as\xED en su primer informe.
Cambi\xF3 a las {time}.
Qu\xE9 se sabe, y de d\xF3nde
No entendido a las {time}:
visto por \xFAltima vez
hace {time}
t\xFA, por {what}
accesible por
contradicci\xF3n
Historial
No se guarda nada de ese tiempo.
Energ\xEDa por d\xEDa
{energy} devueltos
energ\xEDa del {day}
Cargando el plano \u2026
Ninguna habitaci\xF3n tiene forma a\xFAn. Dale esquinas en la tabla [places.rooms], o importa un mapa: homebot places import ARCHIVO.
Planta baja
plano con {count} habitaci\xF3n
plano con {count} habitaciones
Un punto lleno est\xE1 encendido, abierto u ocupado.
fuera de todas las habitaciones
desconocido ahora
Cargando las rutinas \u2026
A\xFAn no hay ninguna rutina.
nueva rutina
propuesta por {name}
pr\xF3xima vez
\xFAltimas veces
ejecutar ahora
darle el derecho
dejar que esta rutina maneje {names}
puede manejar
, porque se aplic\xF3 la escena {scene}
, porque se deshizo la escena {scene}
enviado en un solo mensaje al grupo {name}
enviado en un solo mensaje a la escena {name}
Un dispositivo sin valor queda fuera.
Guarda los valores actuales de:
No hay nada que proponer.
Lo que guarda esta escena no dice sus valores.
Tus costumbres
aceptar
rechazar
conservar
cada vez
homebot busca en el historial de cuatro semanas lo que haces una y otra vez, y lo observa una semana antes de proponerlo.
observa: {name}
buscar costumbres
buscando \u2026
eliminar {name}
tomar los valores actuales
lo hiciste {time} despu\xE9s
lo hiciste {time} antes
no lo hiciste
En la semana de prueba lo hiciste {done} de {total} veces; una rutina acertar\xEDa entre el {low} y el {high} % de las veces.
when: lo que la inicia, una l\xEDnea cada uno
if: todo lo que debe cumplirse entonces
do: sus pasos, una l\xEDnea cada uno
si empieza mientras se ejecuta
el texto
cada paso
Ninguna de las {count} entradas m\xE1s recientes tiene esas palabras.
A\xFAn no ha pasado nada.
las m\xE1s recientes primero
el cliente {name}
un programa desconocido
{issuer} pidi\xF3 {values}
enviado
enviado otra vez
la red lo acept\xF3
inform\xF3 {values}
cambi\xF3 a {values}
{issuer} public\xF3 {text}
se rechaz\xF3 a {issuer}: {reason}
por {issuer}
, porque {device} inform\xF3 {values}
, por {what}
, en camino
, un eco
, por s\xED mismo
, por una persona
, por otro programa
, por el dispositivo o una persona
permitido
pasarela
Preguntando a homebot \u2026
Diagn\xF3stico
Todo est\xE1 bien.
Todo est\xE1 bien. A tener en cuenta:
\u2026 y {count} m\xE1s
Apps
No hay ninguna app en marcha.
A\xFAn no se ha contado nada.
Registro
Las l\xEDneas aparecen aqu\xED seg\xFAn llegan.
Espera tu aprobaci\xF3n
mostrar qu\xE9 permite aprobar {name}
mostrar
La aprobaci\xF3n permite estas \xF3rdenes:
Cambiado desde la aprobaci\xF3n anterior:
aprobar {name}
Cargando el grafo \u2026
Mostrar
Los nodos de la izquierda publican temas, los de la derecha se suscriben.
grafo
{nodes} nodos y {topics} temas
Los primeros valores llegan en dos segundos.
Mensajes
{what} a lo largo del tiempo, {count} puntos
mensajes por segundo
Colas y p\xE9rdidas
mensajes en espera y perdidos
en espera
perdidos
Bucle de eventos
retraso del bucle de eventos
con retraso de
Temas m\xE1s activos
Tema
Receptor m\xE1s lento
habitaci\xF3n
ahora
robot
etiqueta
fuera
en marcha
Colores
como el sistema
claro
oscuro
Esta pantalla
Puertas y ventanas
Humo, agua, movimiento
favorito
Calienta con una ventana abierta
\xDAltimamente aqu\xED
M\xE1s controles
Ning\xFAn dispositivo indica a\xFAn una temperatura.
Ning\xFAn dispositivo indica a\xFAn su potencia o energ\xEDa.
Nada de lo medido funciona.
Ahora
Hoy
Siete d\xEDas
Qui\xE9n la usa ahora
sobre todo {name}
{energy} kWh en otros d\xEDas como este
La casa est\xE1 abierta
La casa est\xE1 cerrada
A\xFAn no hay cerradura, contacto ni alarma.
No hay imagen.
Esta imagen ya no es reciente.
Valores, historial, datos
no se sabe: {names}
las \xFAltimas 24 horas
Nombre y lugar
Dispositivos
Pantallas
escribiendo \u2026
Esto est\xE1 ahora en homebot.toml:
deshacer
siguiente
a la casa
Zona horaria
Latitud
Longitud
El lugar da el amanecer y el atardecer; se queda aqu\xED.
donde est\xE1 esta pantalla
Un servidor en este ordenador
usar {name}
{name} puede controlar dispositivos
A\xF1adir
Direcci\xF3n
Usuario
Contrase\xF1a
Las nuevas pasarelas empiezan con el pr\xF3ximo inicio de homebot.
reiniciar homebot
Cada dispositivo tiene una habitaci\xF3n.
A\xFAn no hay ning\xFAn dispositivo.
Cada pantalla tiene su propio token, que se le puede quitar.
Puede
mirar
mirar y actuar
todo
crear un token
Abre esto una vez en la pantalla; solo se muestra ahora:
Token o c\xF3digo
El c\xF3digo que muestra homebot run deja entrar a la primera pantalla.
Cocina
Sal\xF3n
Dormitorio
Ba\xF1o
Pasillo
Estudio
Jard\xEDn
Garaje
S\xF3tano
Terraza
Rutinas listas
rutinas listas
Ning\xFAn dispositivo de esta casa sirve: {what}
atr\xE1s
calefactor
Personas
Alertas
Copia de seguridad
Persona
Tel\xE9fono en la red
cambiar
enviando \u2026
vincular
homebot sabe qui\xE9n est\xE1 en casa por los tel\xE9fonos de la red y los rastreadores.
Las alertas y preguntas llegan por estas direcciones a tel\xE9fonos, chats y correo.
El mensaje de prueba se ha enviado.
enviar un mensaje de prueba
Como ntfy://TOPIC o mailto://USER:PASSWORD@HOST; appriseit.com los enumera todos.
Contiene todo lo que homebot guarda, menos las contrase\xF1as.
En la app Casa: +, A\xF1adir accesorio, y escanea esto o escribe el c\xF3digo.
Emparejado con {count} controladores.
los emparejamientos con Apple Home
C\xF3digo QR
hacer una copia
Se est\xE1 haciendo \u2026
{name} se ha descargado ({size} kB).
Para restaurarla:
Omitidos por ser secretos: {files}
El c\xF3digo del dispositivo
Pulsa el bot\xF3n del dispositivo y luego \xABvincular\xBB.
quedan {count} s
Pulsa ahora el bot\xF3n: quedan {count} s
{name} est\xE1 vinculado.
Encontrados:
Sus dispositivos aparecen aqu\xED.
Necesita: {what}
una pulsaci\xF3n de su bot\xF3n
humo o calor
fuga de agua
sabotaje
abierto mucho tiempo
pila baja
\xBFHay fuego? Salid y llamad a los bomberos
Abrid las ventanas, salid y pedid ayuda
Ni llamas ni interruptores; abrid las ventanas, salid y pedid ayuda
cierra el agua
ci\xE9rralo
\xBFEst\xE1 abierta la carcasa, o fuera de la pared?
\xBFpila, corriente, alcance?
c\xE1mbiala o c\xE1rgala
homebot show DISPOSITIVO
homebot why DISPOSITIVO muestra los informes
cu\xE1ndo
si
hacer
no hacer nada
empezar de nuevo
despu\xE9s
a la vez
permisos
consulta
preguntar siempre
aprobaci\xF3n
inofensivo
presencia
horas de silencio
frecuencia
enclavamiento
fabricante
modelo
cerradura
persiana o cortina
aire acondicionado
v\xE1lvula de agua
robot aspirador
calentador de agua
humidificador
cortac\xE9sped
central de alarma
sensor de apertura
sensor de presencia
detector de humo o CO
detector de fugas
sensor de lluvia
detector de heladas
sensor de calidad del aire
sensor de suelo
sensor de temperatura
sensor de humedad
sensor de luz
sensor de presi\xF3n
sensor de caudal
pulsador
medidor el\xE9ctrico
reproductor de v\xEDdeo
hogar
localizador
lector de etiquetas
sensor
detector
ajuste
actualizaci\xF3n
todos en casa
secando
temperatura de color
velocidad
temperatura ambiente
modo
acci\xF3n
preajuste
oscilaci\xF3n
oscilaci\xF3n horizontal
modo del ventilador
modo
modo
tono de sirena
localizar
en bruto
versi\xF3n
\xFAltima versi\xF3n
imagen
fuga de agua
conexi\xF3n
bater\xEDa cargando
presi\xF3n
caudal
energ\xEDa devuelta
frecuencia
di\xF3xido de carbono
mon\xF3xido de carbono
PM10
PM1
compuestos org\xE1nicos vol\xE1tiles
calidad del aire
humedad del suelo
intensidad de se\xF1al
imagen de {name}
h\xFAmedo desde
timbre
brillo
hora de dormir
congelador
l\xEDmite
tras
hora
ma\xF1ana
noche
abierto desde
reducido
medidor
durante
movimiento
oscuro bajo
empieza
termina
planta
otra
dentro
calor desde
d\xEDas
queda
fr\xEDo bajo
Un ventilador funciona mientras el ba\xF1o est\xE1 h\xFAmedo.
Un bot\xF3n enciende y apaga una l\xE1mpara.
Aviso inmediato si se abre una puerta y no hay nadie en casa.
Se avisa de un timbrazo, y se ilumina la entrada a oscuras.
Una l\xE1mpara luce desde el anochecer hasta la hora de dormir si hay alguien.
Aviso cuando un congelador lleva un rato demasiado caliente.
Aviso si el garaje queda abierto, y otra vez mientras siga.
Una pulsaci\xF3n en la cama: todo apagado, y aviso si algo est\xE1 abierto.
M\xE1s fresco sin nadie en casa, c\xE1lido con el primero que llega.
M\xE1s fresco de noche.
C\xE1lido por la ma\xF1ana y por la noche.
Un calefactor descansa mientras su ventana est\xE1 abierta.
Aviso cuando la lavadora ha terminado.
Se apagan todas las luces cuando todos se han ido.
Luz mientras alguien se mueve y est\xE1 oscuro; no se toca una l\xE1mpara ya encendida o que alguien cambie entretanto.
Una luz tenue para el camino de noche.
Aviso cuando una planta necesita agua.
Aviso cuando se gasta mucha potencia un rato.
De noche se encienden y apagan l\xE1mparas sin nadie en casa.
Bajada dos tercios mientras hace calor.
Abajo al anochecer, arriba por la ma\xF1ana.
Un enchufe se apaga de noche si su aparato solo espera.
El aspirador limpia una vez al d\xEDa cuando todos se han ido.
Una l\xE1mpara gana luz veinte minutos antes de levantarte.
Luz y aviso cuando hay agua donde no debe.
Luz en el pasillo cuando se abre la puerta a oscuras.
Aviso si una ventana queda abierta y fuera hace fr\xEDo.
configuraci\xF3n err\xF3nea
corregirla y luego: homebot config check
falta una biblioteca
carpeta de datos
hazla tuya o indica otra en HOMEBOT_DATA
archivo de datos
vuelve a instalar el homebot m\xE1s nuevo, o: homebot restore BACKUP
puerto
si homebot ya funciona, preg\xFAntale: homebot doctor
inaccesible
espera un minuto y mira el registro de homebot
corrige la causa del registro y luego: homebot app reload APP, o reinicia homebot
\xBFpila, corriente, alcance? Si ya no existe: homebot forget DEVICE
en disputa
homebot show DEVICE muestra ambos lados; homebot forget DEVICE lo termina
el registro tiene cada uno con su traza: comun\xEDcalo o corr\xEDgelo
el registro y homebot journal dicen m\xE1s
corrige o quita el emisor
env\xEDa lo que su anuncio no explica
corrige el dispositivo o su anuncio
secreto
varios nombres para un identificador: quiz\xE1 varios dispositivos
da a cada dispositivo un identificador propio en sus anuncios; mientras, sus partes tienen estos nombres
sin habitaci\xF3n
aspiradoras que a\xFAn no son robots
a\xF1ade la tabla y reinicia homebot: docs/robots.md
encontrados y a\xFAn sin usar
reinicia homebot tras una tabla nueva: docs/protocols.md
recibidos
rechazados
\xF3rdenes rechazadas
\xF3rdenes fallidas
anuncios
anuncios ambiguos
anuncios rechazados
anuncios derivados
anuncios aplazados
anuncios ignorados
anuncios: bytes de m\xE1s
anuncios: bytes en memoria
dispositivos rechazados
topics rechazados
topics reservados
tipos rechazados
direcciones rechazadas
informes
valores rechazados
demasiado largos
valores ilegibles
fallos
consultas descartadas
caducidades descartadas
cuarentenas
infractores olvidados
respuestas
respuestas tard\xEDas
respuestas desconocidas
descartados por exceso
descartados por largos
descartados por mal formados
activa
no disponible
alta
baja
normal
detecta humo o calor
detecta mon\xF3xido de carbono
detecta gas
est\xE1 mojado
se ha activado
detecta manipulaci\xF3n
indica un problema
est\xE1 abierto
tiene poca bater\xEDa
se ejecut\xF3
a\xFAn no ha informado de nada desde que arranc\xF3 homebot
no se puede contactar con \xE9l
lleva demasiado tiempo en silencio
el propietario no lo ha aprobado
se anunci\xF3 despu\xE9s de aprobar el dispositivo
se cancel\xF3
el control no est\xE1 en marcha; se reinicia solo, v\xE9ase Sistema
la pasarela solo observa; perm\xEDtele dar \xF3rdenes en Sistema, Dispositivos
homebot funciona de prueba y no env\xEDa nada
parada
necesita un c\xF3digo
se est\xE1 vinculando otro dispositivo
el c\xF3digo es incorrecto; si est\xE1s seguro, int\xE9ntalo otra vez
est\xE1 vinculado en otro sitio; qu\xEDtalo all\xED o restabl\xE9celo
demasiados c\xF3digos incorrectos; descon\xE9ctalo un momento
tras un c\xF3digo incorrecto necesita una pausa; int\xE9ntalo m\xE1s tarde
no se encontr\xF3 ning\xFAn dispositivo con este c\xF3digo; \xBFest\xE1 listo para vincularse, en esta red y a\xFAn sin vincular?
un c\xF3digo Matter tiene 11 o 21 cifras, o es un c\xF3digo QR que empieza por MT:
homebot no puede reiniciarse solo aqu\xED; in\xEDcialo de nuevo
no hay nada que deshacer, o el archivo cambi\xF3 despu\xE9s
\xF3rdenes
peticiones rechazadas
clientes cortados
fragmentos descartados
avisos perdidos
mensajes perdidos
conexiones rechazadas
conexiones fallidas
descartados (QoS 0)
descartados para ausentes
descartados por lectura lenta
descartados por grandes
mensajes rechazados
suscripciones rechazadas
mensajes no guardados
inicios de sesi\xF3n fallidos
fallos del diario
fallos del archivo de dispositivos
avisos descartados
avisos fallidos
identificadores cortados
estados perdidos
novedades perdidas
anuncios rechazados
homebot place DISPOSITIVO HABITACI\xD3N
t\xEDtulo
artista
disyuntor
el broker
ning\xFAn programa responde all\xED: in\xEDcialo, o corrige la direcci\xF3n
no hay ruta a ese equipo
sin respuesta
no se conoce el nombre del equipo: corrige la direcci\xF3n
a\xFAn sin conexi\xF3n
sin conexi\xF3n
la conexi\xF3n se cerr\xF3
se perdi\xF3 la conexi\xF3n
el broker ya no responde
el dispositivo ya no tiene esa parte
se contradicen; da solo uno
el c\xF3digo es incorrecto
no tiene
no existe ese dispositivo
hace la casa m\xE1s segura
no tiene sensor de movimiento
a\xFAn no se conocen los dispositivos de la casa
no est\xE1 entre lo que el acceso puede controlar
nadie se enter\xF3; [notify] y el registro dicen por qu\xE9
no hay direcci\xF3n: [notify] no tiene ninguna
uno de sus valores es desconocido
a\xFAn no se cambi\xF3 nada
est\xE1 en la configuraci\xF3n; cambia [places] all\xED
HomeKit no tiene servicio para ello
por s\xED solo
a mano
por otro programa
a mano o por s\xED solo
no se conoce la habitaci\xF3n del dispositivo, as\xED que puede haber alguien
tiene la etiqueta always_ask
desarma la alarma
Ya est\xE1 en vigor.
Home Assistant lo rechaza, o el c\xF3digo es incorrecto
ha cambiado desde tu aprobaci\xF3n
ha cambiado desde entonces; m\xEDralo otra vez
su modo es desconocido; aj\xFAstalo primero
el termostato est\xE1 en otro modo; c\xE1mbialo primero
su otra consigna es desconocida, y ambas van juntas
ese modo no tiene esa consigna
el dispositivo solo puede apagarse, como una placa por seguridad
no es un JPEG, PNG, GIF o WebP de hasta 2 MiB
el token ya no vale, o es de otro`,e=`gateway {name} is away: {reason}
service {name} did not answer within {count} s; whether it acted is unknown
refused ({value}): {reason}
changed back after {count} s, {value}
not sent: {reason}
contradicted: {reason}
the host name cannot be looked up now ({what})
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
el gateway {name} no est\xE1: {reason}
{name} no respondi\xF3 en {count} s; no se sabe si lo hizo
rechazado ({value}): {reason}
volvi\xF3 tras {count} s, {value}
no enviado: {reason}
contradicho: {reason}
ahora no se puede resolver el nombre del equipo ({what})
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
{name} no respondi\xF3`;export{e as reasons,n as texts};
