#include "stage.h"

using fresco::synthesize::TextureSynthesize;

FRESCO_STAGE("texture.synthesize", TextureSynthesize, "Paints a surface with the brush strokes of a picture, without a network")
