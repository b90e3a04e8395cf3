// The sliders in meshcat's panel: one for each pair of sides, each side in a closed folder of its group.
const PANEL_WIDTH = 360;
const NARROW_WINDOW = 720; // below this the panel would cover the face, and starts closed
const STEP = 0.01;

export class Sliders {
  constructor(gui, setup, onMove) {
    this.onMove = onMove;
    this.values = { ...setup.values }; // one for each input
    this.both = {}; // the mean of the sides, for each slider that moves two inputs
    this.sliders = setup.sliders;
    this.controllers = [];
    this.gui = gui;
    gui.width = PANEL_WIDTH;
    const list = gui.domElement.querySelector("ul");
    const meshcatFolders = [...list.children];
    gui.add({ neutral: () => this.moveToNeutral() }, "neutral");
    for (const group of new Set(this.sliders.map((slider) => slider.group))) this.addGroup(group);
    list.append(...meshcatFolders); // below the sliders
    this.display({});
    if (window.innerWidth > NARROW_WINDOW) gui.open();
  }

  // Pixels of the window that the open panel covers.
  get coveredWidth() {
    return this.gui.closed ? 0 : this.gui.width;
  }

  addGroup(group) {
    const sliders = this.sliders.filter((slider) => slider.group === group);
    const folder = this.gui.addFolder(group);
    folder.open();
    for (const slider of sliders) {
      const paired = slider.inputs.length > 1;
      if (paired) this.both[slider.name] = 0;
      this.add(folder, paired ? this.both : this.values, slider.name, slider);
    }
    const pairs = sliders.filter((slider) => slider.inputs.length > 1);
    if (pairs.length === 0) return;
    const sides = folder.addFolder("left, right");
    for (const slider of pairs) {
      for (const input of slider.inputs) this.add(sides, this.values, input, slider);
    }
  }

  add(folder, holder, name, slider) {
    const controller = folder.add(holder, name, slider.lower, 1, STEP);
    const known = name.replace(/_/g, " ").startsWith(slider.label); // a muscle or the jaw: its name says it all
    controller.name(known ? name.replace(/_/g, " ") : `${name.replace("_", " ")} ${slider.label}`);
    controller.domElement.closest("li").title = `${name}: ${slider.label}`;
    controller.domElement.dataset.input = name;
    controller.onChange((value) => this.move([[name, value]]));
    this.controllers.push(controller);
  }

  move(moves) {
    const inputsOf = Object.fromEntries(this.sliders.map((slider) => [slider.name, slider.inputs]));
    const changed = {};
    for (const [name, value] of moves) {
      for (const input of inputsOf[name] ?? [name]) changed[input] = value;
    }
    this.display(changed);
    this.onMove(moves);
  }

  moveToNeutral() {
    this.move(this.sliders.map((slider) => [slider.name, 0]));
  }

  // Shows values that came from elsewhere; nothing is sent, so two pages do not answer each other for ever.
  display(values) {
    Object.assign(this.values, values);
    for (const { name, inputs } of this.sliders) {
      if (inputs.length > 1) this.both[name] = inputs.reduce((sum, input) => sum + this.values[input], 0) / inputs.length;
    }
    for (const controller of this.controllers) controller.updateDisplay();
  }
}
