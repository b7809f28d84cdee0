#pragma once

#include <string>

#include "client/present/render/image.h"

namespace handgraft::client::render {

/// Writes one line in a 5 x 7 bitmap font, `scale` pixels a dot, its top left corner at (x, y).
/// Characters that the font has not (it has printable ASCII) show as `?`; what leaves the image
/// is cut off.
void drawText(Image& image, int x, int y, int scale, Color color, const std::string& text);

/// Width of the line in pixels, without the gap after its last character.
int textWidth(const std::string& text, int scale);

/// Height of a line in pixels, from the top of capitals to the bottom of a `g`.
int textHeight(int scale);

}  // namespace handgraft::client::render
