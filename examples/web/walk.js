// The packet's walk: its section hears "shown" and "hidden" from page.js.
export {};
