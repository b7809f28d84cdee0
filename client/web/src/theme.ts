// Light and dark: as chosen last, else as the system has it.

export type Theme = 'light' | 'dark';

const kKey = 'handgraft-theme';

export function theme(): Theme {
  const { theme } = document.documentElement.dataset;
  if (theme === 'dark' || theme === 'light') return theme;
  const stored = storedTheme();
  if (stored === 'dark' || stored === 'light') return stored;
  return matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
}

export function keepTheme(name: Theme): void {
  document.documentElement.dataset['theme'] = name;
  try {
    localStorage.setItem(kKey, name);
  } catch {
    // Of a file, or in private: it is chosen anew next time.
  }
}

function storedTheme(): string | null {
  try {
    return localStorage.getItem(kKey);
  } catch {
    return null;
  }
}
