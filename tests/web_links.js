// The links of the course's texts to states of the web page, as (http://localhost:8000/#walk?event=3 "what it says").
"use strict";
const fs = require("fs");
const path = require("path");

// Of a text: {hash, title} of each link; null for one of another form.
const linksOf = (text) => [...text.matchAll(/\]\(([^)]*localhost[^)]*)\)/g)].map(([, link]) => {
  const [, hash, title] = /^http:\/\/localhost:8000\/(#\S+) "([^"]+)"$/.exec(link) || [];
  return hash ? { hash, title } : null;
});

// Of all texts, with the name of the text: {file, hash, title}. One of another form is an error.
function courseLinks() {
  const folder = path.join(__dirname, "../examples/course"), links = [];
  for (const file of fs.readdirSync(folder).filter((name) => /^\d\d_.*\.md$/.test(name)))
    for (const link of linksOf(fs.readFileSync(path.join(folder, file), "utf8"))) {
      if (!link) throw new Error(`${file}: a link to the page is not of the form (http://localhost:8000/#... "title")`);
      links.push({ file, ...link });
    }
  return links;
}

module.exports = { linksOf, courseLinks };
