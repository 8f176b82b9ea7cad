// One quantity of one scene against one reference: its arrays, where the page keeps them, and layers
// to draw. A layer is a canvas of which one pixel stands for factor × factor pixels of the image.
const loaded = new Map();

function load(scene, reference, name) {
  const key = [scene.id, reference.name, name].join("\n");
  if (!loaded.has(key)) {
    if (loaded.size > 24) loaded.delete(loaded.keys().next().value);
    loaded.set(key, loadNow(scene, reference, name));
  }
  return loaded.get(key);
}

async function loadNow(scene, reference, name) {
  const entry = reference.quantities[name];
  return entry.arrays ? fromArrays(scene, entry, name) : fromPictures(entry.picture);
}

async function fromArrays({ ny, nx }, { arrays }, name) {
  const ours = await unpack(arrays.ours, ny, nx);
  const theirs = await unpack(arrays.theirs, ny, nx, ours);
  const ratio = await unpack(arrays.ratio, ny, nx);
  const tolerance = arrays.tolerance && await unpack(arrays.tolerance, ny, nx);
  const color = valueColor(name, arrays.low, arrays.high);
  const layers = { ours: painted(ours, ny, nx, color), theirs: painted(theirs, ny, nx, color) };
  for (const scale of ["bands", "linear", "log"]) {
    Object.defineProperty(layers, scale, {
      configurable: true, get() {
        const value = painted(ratio, ny, nx, differenceColor(scale));
        Object.defineProperty(this, scale, { value });
        return value;
      },
    });
  }
  return { ours, theirs, ratio: ratio[0], tolerance: tolerance?.[0], layers, factor: 1, arrays };
}

async function fromPictures(picture) {
  const drawn = await Promise.all(["ours", "theirs", "ratio"].map((which) => decoded(picture[which])));
  const [ours, theirs, bands] = drawn;
  return { layers: { ours, theirs, bands, linear: bands, log: bands }, factor: picture.factor };
}

// The picture behind one of the page's classes.
async function decoded(name) {
  const probe = element("span", { className: name });
  document.body.append(probe);
  const source = getComputedStyle(probe).backgroundImage.slice(5, -2);
  probe.remove();
  const image = new Image();
  image.src = source;
  await image.decode();
  const canvas = element("canvas", { width: image.width, height: image.height });
  canvas.getContext("2d").drawImage(image, 0, 0);
  return canvas;
}

const firstStages = new Map();

async function firstStage(scene, reference) {
  if (!reference.first) return null;
  const key = reference.first.blob;
  if (!firstStages.has(key)) firstStages.set(key, (await unpack(reference.first, scene.ny, scene.nx))[0]);
  return firstStages.get(key);
}

// Object numbers, where some reference's arrays hold them.
async function objectsOf(scene) {
  for (const reference of scene.references) {
    const arrays = reference.quantities.object?.arrays;
    if (arrays) return (await unpack(arrays.ours, scene.ny, scene.nx))[0];
  }
  return null;
}

const more = (scene) => readMore(scene.more);
const read = new Map();

function readMore(id) {
  if (!read.has(id)) read.set(id, readJson(id));
  return read.get(id);
}
