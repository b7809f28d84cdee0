#pragma once

#include <string>

namespace handgraft::hand {

/// What the name of a link, a joint or a segment says of its place on a hand.
struct PartWords {
  /// `thumb`, `index`, `middle`, `ring`, `little`, `palm`; empty if the name says none.
  std::string digit;
  /// `proximal`, `middle`, `distal`, `metacarpal`; empty if the name says none.
  std::string segment;
  /// `right`, `left`; empty if the name says neither.
  std::string side;
  /// The name says `middle` and nothing else of a digit, so that it may mean a segment.
  bool is_vague = false;
};

/// Reads a name word by word; words end at signs, digits and changes of case, and are known
/// whole or as a known beginning, never inside another one ("spring" is no ring).
///
/// Digits: thumb, index, middle, ring, little, pinky and common short forms; Spanish, French,
/// German and Italian names (`pulgar`, `annulaire`, `Zeigefinger`, `mignolo`), with accents or
/// without; th ff mf rf lf
/// alone or before a segment (`ffdistal`, `thmiddle`: a thumb's middle) or a joint's letter
/// (`FFJ1`). Segments: proximal, middle, distal, their short forms (`prox`, `med`, `pm md dd`),
/// knuckle, tip. Numbered fingers (`finger_1`, `f2`) say no digit: people count from either
/// side. Sides: right, left, rh, lh, and a single `r` or `l` before everything else.
PartWords partWordsOf(const std::string& name);

}  // namespace handgraft::hand
