// The icons of @mdi/js, Apache-2.0: the build keeps only those named here.
import * as mdi from "@mdi/js";
import { signal } from "@preact/signals";
import { html } from "./html.js";
import { iconOf, roomKey } from "./layout.js";

export const SIGNS = {
  home: mdi.mdiHome,
  security: mdi.mdiShieldHome,
  climate: mdi.mdiThermometer,
  energy: mdi.mdiLightningBolt,
  plan: mdi.mdiFloorPlan,
  routines: mdi.mdiPlaylistCheck,
  journal: mdi.mdiHistory,
  system: mdi.mdiCog,
  more: mdi.mdiDotsHorizontal,
  right: mdi.mdiChevronRight,
  left: mdi.mdiChevronLeft,
  up: mdi.mdiChevronUp,
  down: mdi.mdiChevronDown,
  stop: mdi.mdiStop,
  close: mdi.mdiClose,
  plus: mdi.mdiPlus,
  minus: mdi.mdiMinus,
  star: mdi.mdiStar,
  starOff: mdi.mdiStarOutline,
  pencil: mdi.mdiPencil,
  power: mdi.mdiPower,
  check: mdi.mdiCheck,
  undo: mdi.mdiUndoVariant,
  backspace: mdi.mdiBackspaceOutline,
  search: mdi.mdiMagnify,
  lights: mdi.mdiLightbulbGroup,
  bulb: mdi.mdiLightbulb,
  bulbOff: mdi.mdiLightbulbOutline,
  door: mdi.mdiDoorOpen,
  window: mdi.mdiWindowOpenVariant,
  lock: mdi.mdiLockOpenVariant,
  garage: mdi.mdiGarageOpenVariant,
  gate: mdi.mdiGateOpen,
  humidity: mdi.mdiWaterPercent,
  shield: mdi.mdiShieldCheck,
  disarmed: mdi.mdiShieldOffOutline,
  armed_home: mdi.mdiShieldHome,
  armed_night: mdi.mdiShieldMoon,
  armed_away: mdi.mdiShieldLock,
  play: mdi.mdiPlay,
  pause: mdi.mdiPause,
  quieter: mdi.mdiVolumeMinus,
  louder: mdi.mdiVolumePlus,
  dock: mdi.mdiHomeImportOutline,
  alert: mdi.mdiAlert,
  hide: mdi.mdiEyeOff,
  show: mdi.mdiEye,
  scene: mdi.mdiPalette,
};

/** Icons of the most usual things, first where they are on, open or moved, then where they are not. */
const USUAL = {
  light: [mdi.mdiLightbulb, mdi.mdiLightbulbOutline],
  ceiling: [mdi.mdiCeilingLight, mdi.mdiCeilingLightOutline],
  floor: [mdi.mdiFloorLamp, mdi.mdiFloorLampOutline],
  desk: [mdi.mdiDeskLamp, mdi.mdiDeskLamp],
  strip: [mdi.mdiLightbulbFluorescentTube, mdi.mdiLightbulbFluorescentTubeOutline],
  lamp: [mdi.mdiLamp, mdi.mdiLampOutline],
  plug: [mdi.mdiPowerPlug, mdi.mdiPowerPlugOutline],
  switch: [mdi.mdiToggleSwitch, mdi.mdiToggleSwitchOffOutline],
  blind: [mdi.mdiBlindsOpen, mdi.mdiBlinds],
  shade: [mdi.mdiRollerShade, mdi.mdiRollerShadeClosed],
  door: [mdi.mdiDoorOpen, mdi.mdiDoorClosed],
  window: [mdi.mdiWindowOpenVariant, mdi.mdiWindowClosedVariant],
  door_lock: [mdi.mdiLockOpenVariant, mdi.mdiLock],
  thermostat: [mdi.mdiRadiator, mdi.mdiRadiatorDisabled],
  occupancy_sensor: [mdi.mdiMotionSensor, mdi.mdiMotionSensorOff],
  smoke_co_alarm: [mdi.mdiSmokeDetectorVariantAlert, mdi.mdiSmokeDetectorVariant],
  water_leak_detector: [mdi.mdiWaterAlert, mdi.mdiWaterOutline],
  video_player: [mdi.mdiTelevision, mdi.mdiTelevisionOff],
  speaker: [mdi.mdiSpeaker, mdi.mdiSpeaker],
  temperature_sensor: [mdi.mdiThermometer, mdi.mdiThermometer],
  humidity_sensor: [mdi.mdiWaterPercent, mdi.mdiWaterPercent],
  light_sensor: [mdi.mdiBrightness5, mdi.mdiBrightness5],
  electrical_meter: [mdi.mdiMeterElectric, mdi.mdiMeterElectricOutline],
  generic_switch: [mdi.mdiGestureTapButton, mdi.mdiGestureTapButton],
  x_robot: [mdi.mdiRobot, mdi.mdiRobot],
  x_unknown: [mdi.mdiDevices, mdi.mdiDevices],
};
/** Things whose icons are loaded when the first is shown. */
const RARE = new Set("dishwasher washer fridge coffee fan pump siren x_humidifier shutter curtain awning garage_door gate water_valve room_air_conditioner water_heater rain_sensor water_freeze_detector x_alarm_panel robotic_vacuum_cleaner x_lawn_mower x_lift camera doorbell air_quality_sensor soil_sensor pressure_sensor flow_sensor x_scene x_person x_household x_tracker x_battery x_setting x_update".split(" "));
const rare = signal(null);
let isAsked = false;

export const isThing = (name) => name in USUAL || RARE.has(name);

/** The two icons of a thing. */
export function thingSigns(name) {
  if (!RARE.has(name)) return USUAL[name];
  if (!isAsked) import("./rare_icons.js").then((loaded) => (rare.value = loaded.RARE_THINGS), () => (isAsked = false));
  isAsked = true;
  return rare.value?.[name] ?? USUAL.x_unknown;
}

/** Words of names, in the languages of the page, with what they mean. */
const LAMPS = [
  [/ceiling|pendant|deck|plafon|techo|soffitt/i, "ceiling"],
  [/floor lamp|standing|steh|lampadaire|de pie|vloer|piantana/i, "floor"],
  [/desk|reading|schreibtisch|lese|bureau|lecture|escritorio|lectura|lees|scrivania|lettura/i, "desk"],
  [/strip|worktop|counter|streifen|led|arbeitsplatte|bandeau|tira|werkblad|striscia/i, "strip"],
  [/night|table|nacht|nuit|noche|notte|tisch|mesa|tavol/i, "lamp"],
];
const MACHINES = [
  [/dishwasher|geschirrsp|sp.lmaschine|lave-vaisselle|lavavajillas|vaatwasser|lavastoviglie/i, "dishwasher"],
  [/wash|dryer|wasch|trockner|lave-linge|lavadora|wasmachine|droger|lavatrice/i, "washer"],
  [/fridge|freezer|k.hl|gefrier|frigo|nevera|koelkast|vriezer/i, "fridge"],
  [/coffee|kaffee|caf.|koffie|caff/i, "coffee"],
];
const ROOMS = [
  [/living|lounge|wohn|salon|s.jour|sala|woon|soggiorno/i, "living room"],
  [/kitchen|k.che|cuisine|cocina|keuken|cucina/i, "kitchen"],
  [/hall|entr|corridor|flur|diele|couloir|pasillo|gang|ingresso/i, "hall"],
  [/kid|child|nursery|kinder|enfant|ni.o|bambin/i, "children"],
  [/bath|shower|bad|bain|ba.o|bagno/i, "bathroom"],
  [/toilet|wc|loo/i, "toilet"],
  [/bed|schlaf|chambre|dormitorio|slaap|camera/i, "bedroom"],
  [/office|study|work|b.ro|arbeit|bureau|despacho|kantoor|studio|ufficio/i, "office"],
  [/garage|carport|garaje/i, "garage"],
  [/garden|terrace|balcon|outside|garten|terrasse|jardin|jard.n|tuin|giardino|außen/i, "garden"],
  [/cellar|basement|keller|cave|s.tano|kelder|cantina/i, "cellar"],
  [/dining|ess|manger|comedor|eet|pranzo/i, "dining room"],
];
/** Icons of rooms. */
export const PLACES = {
  "living room": mdi.mdiSofa,
  kitchen: mdi.mdiSilverwareForkKnife,
  hall: mdi.mdiCoatRack,
  children: mdi.mdiTeddyBear,
  bathroom: mdi.mdiShower,
  toilet: mdi.mdiToilet,
  bedroom: mdi.mdiBed,
  office: mdi.mdiDesk,
  garage: mdi.mdiCar,
  garden: mdi.mdiTree,
  cellar: mdi.mdiStairsDown,
  "dining room": mdi.mdiTableChair,
  room: mdi.mdiFloorPlan,
};
const SCENES = [
  [/evening|dinner|abend|soir|noche|avond|sera|cena|d.ner/i, mdi.mdiWeatherSunset],
  [/film|movie|cinema|kino|cine/i, mdi.mdiMovieOpen],
  [/night|sleep|nacht|nuit|notte|schlaf/i, mdi.mdiWeatherNight],
  [/read|lese|lire|leer|lezen|legg/i, mdi.mdiBookOpenVariant],
  [/off|aus|away|leave|weg|absen|apag|uit|spegn/i, mdi.mdiPower],
  [/morning|morgen|matin|ma.ana|ochtend|mattin/i, mdi.mdiWeatherSunny],
];

const firstOf = (rows, text) => rows.find(([words]) => words.test(text))?.[1];

export const roomSign = (name) => PLACES[iconOf(roomKey(name))] ?? PLACES[firstOf(ROOMS, name) ?? "room"];
export const sceneSign = (name) => firstOf(SCENES, name) ?? SIGNS.scene;

/** What the icon of a device shows, by its kind, else by words of its name, else by its type. */
export function thingOf(device) {
  if (device.type === "light") return firstOf(LAMPS, device.name) ?? "light";
  if (device.type === "plug" || device.type === "switch") return firstOf(MACHINES, device.name) ?? device.type;
  if (/camera|generic/.test(device.type) && /bell|klingel|sonnette|timbre|bel|campanello/i.test(device.name)) return "doorbell";
  if (device.type === "thermostat" && device.settable.includes("cooling_setpoint")) return "room_air_conditioner";
  if (device.type === "door_lock") return device.type;
  return isThing(device.kind) ? device.kind : { contact_sensor: "door", closure: "door", window_covering: "shade" }[device.type] ?? (isThing(device.type) ? device.type : "x_unknown");
}

/** What else the icon of a device may show, by the choice of the owner. */
const CHOICES = [
  ["light", "ceiling", "floor", "desk", "strip", "lamp"],
  ["plug", "switch", "dishwasher", "washer", "fridge", "coffee", "fan", "pump", "siren", "light", "lamp", "video_player", "speaker"],
  ["blind", "shutter", "shade", "curtain", "awning", "garage_door", "gate"],
  ["door", "window", "garage_door", "gate"],
];
export const choicesOf = (device) => CHOICES.find((row) => row.includes(thingOf(device))) ?? [];

export const Sign = ({ path, size = 24 }) => html`<svg class="sign" viewBox="0 0 24 24" width=${size} height=${size} aria-hidden="true"><path d=${path} /></svg>`;
