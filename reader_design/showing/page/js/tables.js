// Tables: sorting by a click on a heading, a filter, a choice of columns, and the table as CSV.

const number = (text) => {
  const found = text.replace(/\u2212/g, "-").replace(/[\u202f\u00a0]/g, "").match(/[-+]?\d*\.?\d+/);
  return found ? Number(found[0]) : NaN;
};

const valueOf = (row, column) => {
  const text = row.cells[column].textContent.trim();
  return column === 0 ? text : Number.isNaN(number(text)) ? text : number(text);
};

const compare = (a, b) => {
  if (typeof a === "number" && typeof b === "number") return a - b;
  if (typeof a === "number") return -1;
  if (typeof b === "number") return 1;
  return a.localeCompare(b, "en", { numeric: true });
};

export const numberIn = (cell) => number(cell.textContent);

export function makeTable(box) {
  const table = box.querySelector("table");
  const rows = [...table.tBodies[0].rows];
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    if (rows.length < 2) return;
    head.setAttribute("aria-sort", "none");
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const order = [...rows].sort((a, b) => compare(valueOf(a, column), valueOf(b, column)));
      table.tBodies[0].append(...(up ? order : order.reverse()));
    });
  });
  const tools = document.createElement("div");
  tools.className = "tools";
  if (rows.length > 7) tools.append(filter(rows));
  const first = Number(box.dataset.first);
  if (first && first < heads.length) tools.append(chooser(table, heads, first));
  tools.append(csv(table));
  box.prepend(tools);
  return { table, rows, heads };
}

function filter(rows) {
  const input = document.createElement("input");
  input.type = "search";
  input.placeholder = "Filter rows";
  input.setAttribute("aria-label", "Filter rows");
  input.addEventListener("input", () => {
    const wanted = input.value.trim().toLowerCase();
    for (const row of rows) {
      const [name, ...cells] = [...row.cells].map((cell) => cell.textContent.toLowerCase());
      row.hidden = !wanted.split(/\s+/).every((word) => name.includes(word))
        && !cells.some((cell) => cell.includes(wanted));
    }
  });
  return input;
}

function chooser(table, heads, first) {
  const details = document.createElement("details");
  details.className = "columns";
  details.innerHTML = "<summary><span class=\"label\"></span></summary><div></div>";
  const show = (column, on) => {
    for (const row of [table.tHead.rows[0], ...table.tBodies[0].rows])
      row.cells[column].style.display = on ? "" : "none";
  };
  const boxes = heads.map((head, column) => {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = column < first;
    box.disabled = column === 0;
    label.append(box, ` ${head.textContent}`);
    details.lastChild.append(label);
    box.addEventListener("change", () => { show(column, box.checked); said(); });
    if (!box.checked) show(column, false);
    return box;
  });
  const said = () => {
    const shown = boxes.filter((box) => box.checked).length;
    details.querySelector(".label").textContent = `Columns: ${shown} of ${heads.length}`;
  };
  for (const [text, on] of [["All", () => true], ["First", (column) => column < first]]) {
    const button = document.createElement("button");
    button.className = "small";
    button.textContent = text;
    button.addEventListener("click", () => {
      boxes.forEach((box, column) => { box.checked = on(column); show(column, box.checked); });
      said();
    });
    details.lastChild.prepend(button);
  }
  said();
  document.addEventListener("click", (event) => {
    if (!details.contains(event.target)) details.open = false;
  });
  return details;
}

function csv(table) {
  const quoted = (cell) => `"${cell.textContent.trim().replace(/\u2212/g, "-")
    .replace(/[\u202f\u00a0]/g, " ").replace(/"/g, '""')}"`;
  const button = document.createElement("button");
  button.className = "small";
  button.textContent = "CSV";
  button.title = "Save this table as a CSV file";
  button.addEventListener("click", () => {
    const lines = [...table.rows].map((row) => [...row.cells].map(quoted).join(","));
    save("table.csv", `data:text/csv;charset=utf-8,${encodeURIComponent(`${lines.join("\n")}\n`)}`);
  });
  return button;
}

export function save(name, url) {
  const link = document.createElement("a");
  link.download = name;
  link.href = url;
  link.click();
}
