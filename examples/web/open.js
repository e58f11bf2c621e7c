// Opens a scene in a module: a script for workers and for the page alike. The model is one of files.js.
"use strict";
const MATERIAL_WORDS = 13; // as in files.js

function mustOpen(module, status) {
  if (status) throw new Error(module.UTF8ToString(module._web_error()));
}

// Opens a scene of a number, or if there is one, a model. One that cannot be opened leaves the scene of before.
function openScene(module, { scene, light, model }) {
  if (model) {
    const { points, normals, words, materials, texcoords, images } = model;
    let at = module._web_model_room(model.count, words.length / MATERIAL_WORDS, texcoords !== null) >> 2;
    if (!at) throw new Error("there is not enough memory for the model");
    for (const values of [points, normals, words, materials, texcoords ?? []]) {
      (values === materials ? module.HEAPU32 : module.HEAPF32).set(values, at);
      at += values.length;
    }
    for (const { width, height, pixels } of images) {
      const room = module._web_image_room(width, height) >> 2;
      if (!room) throw new Error("there is not enough memory for its images");
      module.HEAPU32.set(pixels, room);
    }
  }
  mustOpen(module, model ? module._web_open_model(light) : module._web_open(scene, light));
}
