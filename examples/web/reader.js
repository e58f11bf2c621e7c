// Reads files that were dropped, apart from the page: one that takes long holds nothing up, and can be given up. The page
// sends {files, options}, as files.js wants them, and hears {model} or {refused}.
import { describe, IMAGE_WORD, imageSize, MATERIAL_WORDS, readModel } from "./files.js";

const LARGEST = 1024; // pixels along an edge of an image, as it is used

async function bytesOf(file) {
  try {
    return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
  } catch {
    throw new Error(`${file.name} is refused: it cannot be read`);
  }
}

// An image as the browser decodes it, { width, height, pixels: sRGB and opacity }, made smaller if it is large; null if it
// cannot be.
async function decoded(bytes) {
  try {
    const [width, height] = imageSize(bytes).map((x) => Math.min(x, LARGEST)), canvas = new OffscreenCanvas(width, height);
    const bitmap = await createImageBitmap(new Blob([bytes]), { premultiplyAlpha: "none", colorSpaceConversion: "none" });
    const pen = canvas.getContext("2d");
    pen.drawImage(bitmap, 0, 0, width, height);
    bitmap.close();
    return { width, height, pixels: new Uint32Array(pen.getImageData(0, 0, width, height).data.buffer) };
  } catch {
    return null;
  }
}

// Decodes a model's images. Materials go without those that cannot be.
async function decodeImages(model) {
  const images = [];
  for (const bytes of model.images) images.push(await decoded(bytes)); // one by one, for they are large
  for (let at = IMAGE_WORD; at < model.words.length; at += MATERIAL_WORDS)
    if (model.words[at] >= 0 && !images[model.words[at]]) {
      model.words[at] = -1;
      model.unused.add("textures");
    }
  model.images = images.map((one) => one ?? { width: 1, height: 1, pixels: new Uint32Array(1) });
}

onmessage = async ({ data: { files, options } }) => {
  try {
    const model = readModel(await Promise.all(files.map(bytesOf)), options);
    await decodeImages(model);
    const { points, normals, texcoords, words, materials } = model;
    postMessage({ model: { ...model, said: describe(model) } },
      [points, normals, texcoords, words, materials].filter(Boolean).map((array) => array.buffer));
  } catch (error) {
    postMessage({ refused: error.message });
  }
};
