// What the page's classic scripts bring: the charting library and host/report/panels.js.
declare const Dygraph: any;
declare function closingPanels(root: HTMLElement): {
  draw(closing: any, range: [number, number] | null, stripped: boolean): void;
  range(): [number, number] | null;
  actions: { [name: string]: () => void };
};
