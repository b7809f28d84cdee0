// Strokes of the page's icons, 24 by 24.

export const kIcons = {
  patches: 'M12 3v4M12 17v4M3 12h4M17 12h4M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z',
  fingers: 'M8 13V5a1.5 1.5 0 0 1 3 0v6m0-1V3.5a1.5 1.5 0 0 1 3 0V11m0-5a1.5 1.5 0 0 1 3 0v8c0 4-2 7-5.5 7S7 19 5 15l-1-2.5a1.4 1.4 0 0 1 2.5-1L8 13.500',
  object: 'M12 3l8 4.500v9L12 21l-8-4.500v-9zM12 12l8-4.500M12 12v9M12 12L4 7.500',
  palm: 'M6 21v-5L4 12.500a1.4 1.4 0 0 1 2.500-1L8 13.500V7h9v8c0 3-1 4.500-2 6zM12.500 1v4m-2-2l2-2 2 2M19 11h4m-2-2l2 2-2 2',
  undo: 'M9 7L4 12l5 5M4 12h10a6 6 0 0 1 6 6',
  redo: 'M15 7l5 5-5 5M20 12H10a6 6 0 0 0-6 6',
  frame: 'M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5',
  theme: 'M12 3a9 9 0 1 0 0 18zM12 3a9 9 0 0 1 0 18',
  save: 'M12 4v10m-4-4l4 4 4-4M4 18v2h16v-2',
  panel: 'M4 5h16v14H4zM14 5v14',
};
