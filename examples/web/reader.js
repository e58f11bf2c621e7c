// Reads files that were dropped, apart from the page: one that takes long holds nothing up, and can be given up. The page
// sends {files, options}, as files.js wants them, and hears {model} or {refused}.
import { readModel } from "./files.js";

async function bytesOf(file) {
  try {
    return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
  } catch {
    throw new Error(`${file.name} is refused: it cannot be read`);
  }
}

onmessage = async ({ data: { files, options } }) => {
  try {
    const model = readModel(await Promise.all(files.map(bytesOf)), options);
    postMessage({ model }, [model.points, model.normals, model.words, model.materials].map((array) => array.buffer));
  } catch (error) {
    postMessage({ refused: error.message });
  }
};
