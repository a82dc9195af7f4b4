//! Words of renderers, shading languages and compositing programs, and what is written here instead.
//!
//! The one table behind every message about a name that nothing has: those of the compiler, of a run, of `pse check`,
//! of the language server, of `pse repl` and of `pse view`.

use crate::spelling::nearest;
use std::collections::HashMap;
use std::sync::LazyLock;

/// Words that mean the same, and a sentence that says what to write.
type Entry = (&'static [&'static str], &'static str);

const DEPTH: &str = "The depth is called `depth` here.";
const COLOR: &str = "The colour is called `color` here: the input's, and the one that is written.";
const UV: &str = "Texture coordinates are called `uv` here, with the components `uv.x` and `uv.y`.";
const INCIDENT: &str = "The direction from the eye to the point is called `I` here; `-I` leads to the eye.";
const BITANGENT: &str = "The direction in which `uv.y` grows is called `dPdv` here.";
const TIME: &str = "Time is counted in frames: `frame / 24` is in seconds at 24 frames a second.";
const LIGHT: &str = "There are no lights; choose a direction: `L = direction([-0.5 -0.7 0.8])`.";
const OBJECT_SPACE: &str = "The point in the space of its object is `transform(\"object\", point)` here.";

/// Variables. RenderMan and OSL (`P`), Houdini (`@P`), Nuke, Blender, GLSL, HLSL, SeExpr and MaterialX.
static VARIABLES: &[Entry] = &[
    (
        &[
            "P",
            "Pw",
            "Pworld",
            "pos",
            "position",
            "worldPos",
            "world_pos",
            "worldPosition",
            "world_position",
            "positionWorld",
            "positionWS",
            "posWS",
            "vPosition",
            "v_position",
            "a_position",
            "hitpoint",
            "hitPoint",
            "fragPos",
        ],
        "The visible point is called `point` here.",
    ),
    (
        &[
            "N",
            "Nn",
            "Nf",
            "Ng",
            "Nw",
            "Nworld",
            "nrm",
            "normalWS",
            "worldNormal",
            "world_normal",
            "normalWorld",
            "vNormal",
            "v_normal",
            "a_normal",
            "surfaceNormal",
            "shadingNormal",
        ],
        "The normal is called `normal` here.",
    ),
    (&["Z", "Zdepth", "zdepth", "ZDepth", "depthZ", "sceneDepth", "linearDepth", "gl_FragDepth"], DEPTH),
    (
        &[
            "Ci",
            "Cs",
            "Cd",
            "C",
            "Cf",
            "Col",
            "col",
            "rgb",
            "rgba",
            "beauty",
            "combined",
            "gl_FragColor",
            "fragColor",
            "FragColor",
            "fragmentColor",
            "outColor",
            "out_color",
            "SV_Target",
            "finalColor",
            "geomcolor",
            "vColor",
            "displayColor",
        ],
        COLOR,
    ),
    (
        &["Oi", "Os", "Of", "Alpha", "opacity", "coverage", "transparency"],
        "Coverage is one number here, `alpha`: 1 where the surface is opaque.",
    ),
    (
        &[
            "st",
            "ST",
            "uvw",
            "texcoord",
            "texCoord",
            "TexCoord",
            "texcoord0",
            "TEXCOORD0",
            "texcoords",
            "uvs",
            "vUv",
            "vUV",
            "v_uv",
            "UVMap",
            "uvCoord",
            "gl_TexCoord",
            "parametric",
        ],
        UV,
    ),
    (&["s", "u", "ss"], "The first texture coordinate is `uv.x` here."),
    (&["t", "v", "tt"], "The second texture coordinate is `uv.y` here; time is counted by `frame`."),
    (
        &[
            "Pref",
            "rest",
            "Po",
            "Pobj",
            "positionObject",
            "positionOS",
            "objectPosition",
            "Generated",
            "Object",
        ],
        OBJECT_SPACE,
    ),
    (
        &[
            "V",
            "viewDir",
            "viewdir",
            "viewDirection",
            "viewdirection",
            "view_dir",
            "rayDir",
            "ray_direction",
            "eyeDir",
            "incident",
            "incoming",
            "Incoming",
        ],
        INCIDENT,
    ),
    (
        &[
            "E",
            "camPos",
            "cameraPos",
            "cameraPosition",
            "camera_position",
            "eyePos",
            "eyePosition",
            "viewPos",
            "viewPosition",
            "viewposition",
            "_WorldSpaceCameraPos",
        ],
        "The position of the eye is called `eye` here.",
    ),
    (
        &["L", "Lw", "lightDir", "lightdir", "light_dir", "lightDirection", "lightPos", "Cl", "Ol", "light"],
        LIGHT,
    ),
    (
        &["T", "tangent", "Tangent", "tangentu", "tangentU", "tangentWorld", "dPds"],
        "The direction in which `uv.x` grows is called `dPdu` here.",
    ),
    (&["B", "bitangent", "binormal", "tangentv", "tangentV", "dPdt"], BITANGENT),
    (&["time", "Time", "TIME", "iTime", "u_time", "uTime", "_Time", "seconds", "simtime"], TIME),
    (
        &["F", "FF", "frameno", "iFrame", "Frame", "frame_number", "frameNumber", "fframe"],
        "The number of the frame is called `frame` here.",
    ),
    (
        &["iResolution", "u_resolution", "uResolution", "imageSize", "image_size", "dimensions"],
        "The size of the picture is `resolution` here: `[columns rows]`.",
    ),
    (&["width", "xres", "cols", "columns"], "The width of the picture is `resolution.x` here."),
    (&["height", "yres", "rows"], "The height of the picture is `resolution.y` here."),
    (
        &[
            "gl_FragCoord",
            "fragCoord",
            "FragCoord",
            "SV_Position",
            "pixelCoord",
            "screenPos",
            "gl_PointCoord",
            "raster",
        ],
        "The column and the row of the pixel are `pixel` here.",
    ),
    (&["x", "px"], "The column of the pixel is `pixel.x` here, the first coordinate of the point `point.x`."),
    (&["y", "py"], "The row of the pixel is `pixel.y` here, the second coordinate of the point `point.y`."),
    (&["z", "pz"], "The third coordinate of the point is `point.z` here, the depth `depth`."),
    (&["M_PI", "kPi"], "It is called `pi` here."),
    (&["TAU", "tau", "TWO_PI", "TWOPI", "two_pi", "twopi", "M_2PI", "PI2"], "Write `2 * pi`."),
    (&["e", "M_E", "euler"], "Write `exp(1)`."),
    (&["inf", "INF", "INFINITY", "Inf", "FLT_MAX", "M_INFINITY"], "It is called `infinity` here."),
    (&["nan", "NaN", "NAN"], "Write `0 / 0`; test for it with `isnan(x)`."),
    (
        &[
            "id",
            "ID",
            "Id",
            "objectid",
            "objectId",
            "objectID",
            "object_id",
            "ObjectID",
            "objid",
            "IndexOB",
            "object_index",
            "instanceID",
            "instance_id",
            "primID",
            "primnum",
            "faceId",
            "geomID",
            "materialID",
        ],
        "The number of the surface is called `surface` here.",
    ),
    (
        &["velocity", "vel", "mv", "motionvector", "motionVector", "motionVectors", "motion_vector"],
        "Motion from frame to frame is called `motion` here.",
    ),
    (
        &[
            "basecolor",
            "baseColor",
            "base_color",
            "BaseColor",
            "diffuseColor",
            "diffuse_color",
            "DiffCol",
            "diffcol",
        ],
        "The colour of the surface without light is called `albedo` here.",
    ),
    (&["orange", "brown", "purple", "pink", "violet"], "Write a colour as red, green and blue: `[1 0.3 0]`."),
    (
        &["null", "None", "nil", "undefined", "NULL"],
        "There is no such value. A variable gets its value from its first assignment.",
    ),
];

/// Functions.
static FUNCTIONS: &[Entry] = &[
    (&["normalize", "normalise", "normalized", "unit"], "For a vector of length 1, write `direction(v)`."),
    (
        &[
            "vec2", "vec3", "vec4", "float2", "float3", "float4", "half3", "half4", "vector", "vector2",
            "vector3", "vector4", "rgb", "rgba", "color3", "color4", "set",
        ],
        "Write a vector in brackets: `[1 0 0]`.",
    ),
    (
        &["mat2", "mat3", "mat4", "float3x3", "float4x4", "matrix", "matrix3", "matrix4"],
        "Write a matrix as rows in brackets: `[[1 0] [0 1]]`.",
    ),
    (&["dotproduct", "dot_product", "DotProduct", "dotp"], "It is called `dot(a, b)` here."),
    (&["crossproduct", "cross_product", "CrossProduct"], "It is called `cross(a, b)` here."),
    (
        &["ch", "chf", "chi", "chv", "chp", "parm", "getattr"],
        "Use a param: the line param amount = 1 declares it, `amount` reads it, and --set amount=2 sets it.",
    ),
    (
        &["MixRGB", "mixrgb", "mix_rgb", "keymix", "Keymix", "KeyMix", "Dissolve", "dissolve", "MixColor"],
        "To blend two values, write `mix(a, b, t)`: `a` where `t` is 0, `b` where it is 1.",
    ),
    (
        &["cryptomatte", "Cryptomatte", "cryptomask", "getmatte"],
        "Read the channels of a cryptomatte as `CryptoObject00`, `CryptoObject01`, …; docs/antialiasing.md has a \
         program that makes a matte of them.",
    ),
    (&["float", "double", "half"], "Every number is a float: remove it."),
    (&["int", "integer", "toint"], "Write `trunc(x)`, or `floor(x)`."),
    (&["bool"], "Write `x != 0`."),
    (
        &[
            "ramp",
            "colorramp",
            "color_ramp",
            "colorRamp",
            "ColorRamp",
            "colourramp",
            "gradient",
            "colorband",
            "curve",
            "chramp",
            "valToRGB",
            "splinecurve",
            "hermite",
            "bezier",
            "catmullrom",
            "bspline",
            "keyframe",
        ],
        "For a ramp through knots with `t` from 0 to 1, write `linear(t, a, b, c)`, or `spline(t, a, b, c, d)` for a smooth one.",
    ),
    (
        &["interp", "interpolate", "lookup", "lut", "lut1d"],
        "To look up a vector, write `table(v, x)`; to interpolate knots, `linear(t, a, b, c)` or `spline(t, a, b, c, d)`.",
    ),
    (
        &[
            "fit",
            "fit01",
            "fit10",
            "fit11",
            "efit",
            "remap",
            "rescale",
            "map_range",
            "mapRange",
            "maprange",
            "maptorange",
            "linmap",
            "expand",
            "setRange",
            "rerange",
        ],
        "To map `x` from the range `a` to `b` to the range `c` to `d`, write `mix(c, d, boxstep(a, b, x))`.",
    ),
    (&["linearstep", "linstep", "boxramp"], "A straight ramp from 0 to 1 is `boxstep(a, b, x)`."),
    (
        &["smooth", "smoothlinear", "hermitestep", "ease", "easeInOut"],
        "A smooth step from 0 to 1 is `smoothstep(a, b, x)`.",
    ),
    (&["heaviside", "threshold", "sstep"], "A step from 0 to 1 is `step(edge, x)`."),
    (&["blend", "crossfade", "lerpf"], "A blend of two values is `mix(a, b, t)`."),
    (
        &[
            "rand",
            "rand01",
            "nrandom",
            "frand",
            "drand48",
            "hash",
            "hash11",
            "hash12",
            "hash13",
            "hash21",
            "hash22",
            "hash31",
            "hash33",
            "hashf",
            "random2",
            "random3",
            "randval",
            "pseudorandom",
            "jitter",
        ],
        "A random number for each point is `random(p)`.",
    ),
    (
        &["cellnoise", "cell_noise", "hashnoise", "cellnoise2d", "cellnoise3d", "blocknoise"],
        "A random number for each cell is `random(floor(p))`, or `Noise(p, kind = \"white\")`.",
    ),
    (
        &[
            "worley",
            "voronoi",
            "voronoi2d",
            "voronoi3d",
            "cvoronoi",
            "pvoronoi",
            "vornoise",
            "wnoise",
            "worleynoise",
            "worleynoise2d",
            "worleynoise3d",
            "cellular",
            "cellularnoise",
            "voronoise",
        ],
        "It is a kind of noise: `Noise(p, kind = \"cellular\")`.",
    ),
    (
        &["simplex", "simplexnoise", "simplex_noise", "opensimplex", "xnoise"],
        "It is a kind of noise: `Noise(p, kind = \"simplex\")`.",
    ),
    (&["gabor", "gabornoise"], "It is a kind of noise: `Noise(p, kind = \"gabor\")`."),
    (
        &["whitenoise", "white_noise"],
        "It is a kind of noise: `Noise(p, kind = \"white\")`; or write `random(p)`.",
    ),
    (&["valuenoise", "value_noise"], "It is a kind of noise: `Noise(p, kind = \"value\")`."),
    (
        &[
            "snoise",
            "perlin",
            "perlinnoise",
            "perlin_noise",
            "cnoise",
            "unoise",
            "onoise",
            "anoise",
            "noise1",
            "noise2",
            "noise3",
            "noise4",
            "noise2d",
            "noise3d",
            "noisetexture",
        ],
        "Noise is called `Noise(p)` here.",
    ),
    (
        &["cnoise3", "vectornoise", "colornoise", "vector_noise"],
        "Noise with three components is `Vnoise(p)`.",
    ),
    (
        &["curlnoise", "curl_noise", "curlnoise2d", "curlxnoise", "curlxnoise2d", "curlgxnoise"],
        "It is called `curl(p)` here.",
    ),
    (
        &[
            "fbm",
            "fractal",
            "fractalnoise",
            "fractal_noise",
            "fractal3d",
            "cfbm",
            "vfbm",
            "octaves",
            "musgrave",
        ],
        "For a sum of octaves of noise, write `fBm(p)`, `fractalsum(p)` or `turbulence(p)`.",
    ),
    (&["turb", "turbulent", "turbnoise"], "It is called `turbulence(p)` here."),
    (&["ridgedmf", "ridged_multifractal", "ridgednoise", "ridge"], "It is called `ridged(p)` here."),
    (
        &[
            "luma",
            "lum",
            "luminosity",
            "rgb_to_luma",
            "rgb2luma",
            "rgb2gray",
            "grayscale",
            "greyscale",
            "rgbtobw",
            "bw",
            "brightness",
        ],
        "The luminance of a colour is `luminance(color)`.",
    ),
    (
        &["saturation", "desaturate", "desat", "adjustsaturation", "colorsaturation"],
        "Write `mix(luminance(color), color, amount)`: an amount of 0 is grey.",
    ),
    (&["contrast", "adjustcontrast"], "Write `mix(0.5, x, amount)`: an amount above 1 is more contrast."),
    (&["exposure", "stops"], "Write `color * 2 ^ stops`."),
    (&["premult", "premultiply", "Premult"], "Write `color * alpha`."),
    (&["unpremult", "unpremultiply", "Unpremult", "unpre"], "Write `alpha > 0 ? color / alpha : color`."),
    (
        &["under", "merge", "alphaover", "composite", "comp"],
        "To put a picture over another, write `over(a, alpha, b)`.",
    ),
    (&["screen"], "Write `1 - (1 - a) * (1 - b)`."),
    (&["invert", "oneminus", "one_minus", "complement", "rgbinvert"], "Write `1 - x`."),
    (&["add", "plus"], "Write `a + b`."),
    (&["sub", "subtract", "minus"], "Write `a - b`."),
    (&["mul", "times", "mult"], "Write `a * b`; for matrices, `multiply(a, b)`."),
    (&["div", "divide"], "Write `a / b`."),
    (
        &["blur", "boxblur", "gaussian", "gaussianblur", "Blur", "defocus", "soften", "convolve"],
        "A program reads one pixel at a time. To blur a file, write `texture(\"file.exr\", s, t, width = 0.01)`.",
    ),
    (
        &[
            "dilate",
            "erode",
            "median",
            "sharpen",
            "edgedetect",
            "neighbour",
            "neighbor",
            "pixelat",
            "getpixel",
        ],
        "A program reads one pixel at a time, without its neighbours.",
    ),
    (&["clamp01", "saturate", "sat", "clip", "clampf"], "To limit a number to 0 … 1, write `clamp(x)`."),
    (&["fract", "fraction"], "It is called `frac(x)` here."),
    (
        &[
            "texture2D",
            "texture3D",
            "textureLod",
            "texture2DLod",
            "tex2D",
            "tex2Dlod",
            "tex2Dgrad",
            "tex2Dbias",
            "tex3D",
            "tex1D",
            "tex",
            "texelFetch",
            "image",
            "imagefile",
            "colormap",
            "rawcolormap",
            "readimage",
            "map",
            "sampleTexture",
        ],
        "To look up an image, write `texture(\"file.png\", uv.x, uv.y)`.",
    ),
    (
        &["textureCube", "texCUBE", "samplerCube", "envmap", "environmentmap", "reflectionmap"],
        "To look up the surroundings, write `environment(\"sky.exr\", reflect(I, normal))`.",
    ),
    (&["fmod", "modulo", "rem", "remainder", "imod"], "Write `a % b`."),
    (&["wrap", "repeat"], "Write `mod(x, period)`."),
    (&["sawtooth", "saw"], "Write `frac(x)`."),
    (&["triangle", "trianglewave", "pingpong"], "Write `abs(2 * frac(x) - 1)`."),
    (&["atan2", "atan2f"], "It is called `atan(y, x)` here."),
    (&["powf", "power"], "Write `x ^ y`."),
    (&["inversesqrt", "rsqrt", "invsqrt"], "Write `1 / sqrt(x)`."),
    (&["sqr", "square"], "Write `x ^ 2`."),
    (&["cube"], "Write `x ^ 3`."),
    (&["fabs", "fabsf"], "It is called `abs(x)` here."),
    (&["ln", "loge"], "The natural logarithm is `log(x)`."),
    (&["lg"], "The logarithm to the base of 10 is `log10(x)`."),
    (&["rint", "nint"], "It is called `round(x)` here."),
    (&["sgn", "signum"], "It is called `sign(x)` here."),
    (
        &["deg", "rad2deg", "todegrees", "to_degrees", "degree"],
        "To convert radians to degrees, write `degrees(x)`.",
    ),
    (
        &["rad", "deg2rad", "toradians", "to_radians", "radian"],
        "To convert degrees to radians, write `radians(x)`.",
    ),
    (&["dist", "ptdist"], "It is called `distance(a, b)` here."),
    (&["mag", "magnitude"], "The length of a vector is `length(v)`."),
    (&["len", "count"], "The number of elements is `size(v)`, the length of an arrow `norm(v)`."),
    (&["avg", "average"], "The mean of the elements of a vector is `mean(v)`."),
    (&["push", "push_back", "pushback", "concat"], "To add an element, write `append(v, x)`."),
    (&["range", "arange", "linspace"], "Write a range as `[1 .. 10]`."),
    (&["select", "choose", "iif", "cond", "ternary", "where"], "Write `condition ? a : b`."),
    (&["dFdx", "ddx", "dfdx", "ddx_fine"], "The change to the next pixel of a row is `Du(e)`."),
    (
        &["dFdy", "ddy", "dfdy", "ddy_fine", "Deriv"],
        "The change to the next pixel is `Du(e)` along a row and `Dv(e)` along a column.",
    ),
    (&["fwidth", "filterWidth"], "How much an expression changes over a pixel is `filterwidth(e)`."),
    (
        &["bump", "displace", "bumpmap"],
        "Move the point, and compute the normal of the result: `calculatenormal(point + normal * height)`.",
    ),
    (
        &["ptransform", "xform", "mtransform", "toworld", "tospace"],
        "To transform a point into a space, write `transform(\"object\", point)`.",
    ),
    (&["translate"], "The matrix that moves points is `translation(v)`."),
    (
        &["rot", "rotate2d", "rotate2D", "rotate3d", "rotateX", "rotateY", "rotateZ"],
        "To rotate a point, write `rotate(p, angle, [0 0 1])`.",
    ),
    (&["schlick", "kfresnel"], "It is called `fresnel(cosine)` here."),
    (
        &[
            "trace",
            "occlusion",
            "ao",
            "gather",
            "raytrace",
            "shadow",
            "indirectdiffuse",
            "curvature",
            "pcopen",
            "pointcloud",
        ],
        "A program reads the point under one pixel. It cannot trace rays or read other points.",
    ),
    (&["checkerboard", "checker2d", "checkers"], "It is called `checker(p)` here."),
    (&["bricks"], "It is called `brick(uv)` here."),
    (&["wood"], "There are `pine(p)`, `oak(p)`, `walnut(p)` and `zebrawood(p)`."),
    (
        &[
            "aces",
            "ACES",
            "ACESFilm",
            "tonemap",
            "tone_map",
            "filmic",
            "reinhard",
            "agx",
            "AgX",
            "ocio",
            "colorspace",
            "OCIOColorSpace",
            "applylut",
        ],
        "There is no tone mapping: colours are linear light, and pictures are written as sRGB.",
    ),
    (
        &[
            "srgb",
            "sRGB",
            "tosrgb",
            "toSRGB",
            "linearToSRGB",
            "linear2srgb",
            "lin2srgb",
            "rgb_to_srgb",
            "LinearToGamma",
            "togamma",
        ],
        "To encode linear light, write `linear_to_srgb(color)`; pictures are encoded automatically when written.",
    ),
    (
        &[
            "tolinear",
            "toLinear",
            "srgb2lin",
            "srgb2linear",
            "sRGBToLinear",
            "srgbtolinear",
            "degamma",
            "GammaToLinear",
        ],
        "To convert sRGB to linear light, write `srgb_to_linear(color)`.",
    ),
    (&["gamma"], "Write `gammacorrect(2.2, x)`, or `linear_to_srgb(color)` for the curve of sRGB."),
    (&["hsv", "hsvtorgb", "hsv2rgb", "HSVtoRGB", "hsvToRgb"], "It is called `hsv_to_rgb(color)` here."),
    (&["rgbtohsv", "rgb2hsv", "RGBtoHSV", "rgbToHsv"], "It is called `rgb_to_hsv(color)` here."),
    (&["hsl", "hsltorgb", "hsl2rgb", "hsi"], "It is called `hsl_to_rgb(color)` here."),
    (&["rgbtohsl", "rgb2hsl"], "It is called `rgb_to_hsl(color)` here."),
    (&["printf", "puts", "echo", "console"], "To print a value, write `print(x)`."),
];

static BY_VARIABLE: LazyLock<HashMap<&str, &str>> = LazyLock::new(|| by_word(VARIABLES));
static BY_FUNCTION: LazyLock<HashMap<&str, &str>> = LazyLock::new(|| by_word(FUNCTIONS));

fn by_word(entries: &[Entry]) -> HashMap<&'static str, &'static str> {
    entries.iter().flat_map(|(words, instead)| words.iter().map(|word| (*word, *instead))).collect()
}

/// What to write instead of a variable of another language, as a sentence. A function's name says it too.
pub fn variable(name: &str) -> Option<&'static str> {
    let exact = || BY_VARIABLE.get(name).or_else(|| BY_FUNCTION.get(name));
    // Short words of different case are different words: `N` and `n`.
    let loose = || if name.len() < SHORTEST_LOOSE { None } else { LOOSE.get(&without_case(name)) };
    exact().or_else(loose).copied()
}

/// Variables' words of so many bytes are known whatever their capitals and underlines.
const SHORTEST_LOOSE: usize = 4;

/// The variables' words without capitals and underlines: `WorldPosition`, `world_position`.
static LOOSE: LazyLock<HashMap<String, &'static str>> = LazyLock::new(|| {
    let long = BY_VARIABLE.iter().filter(|(word, _)| word.len() >= SHORTEST_LOOSE);
    let mut words: Vec<_> = long.map(|(word, here)| (without_case(word), *here)).collect();
    // Of words that differ in case alone, always the same one.
    words.sort_unstable();
    words.into_iter().collect()
});

fn without_case(word: &str) -> String {
    word.replace('_', "").to_lowercase()
}

/// What to write instead of a function of another language, as a sentence. A variable's name says it too.
pub fn function(name: &str) -> Option<&'static str> {
    BY_FUNCTION.get(name).or_else(|| BY_VARIABLE.get(name)).copied()
}

/// The output that a word of another language stands for, if a program assigns it: `color` or `alpha`.
pub fn output(name: &str) -> Option<&'static str> {
    Some(match name {
        "Ci" | "gl_FragColor" | "gl_FragData" | "fragColor" | "FragColor" | "fragmentColor" | "outColor"
        | "out_color" | "SV_Target" | "finalColor" | "colour" | "Colour" | "Color" | "COLOR"
        | "outputColor" | "out_Color" => "color",
        "Oi" | "Alpha" | "ALPHA" | "outAlpha" => "alpha",
        _ => return None,
    })
}

/// What to write instead of a channel of another program, `rgba.alpha`, as a sentence.
pub fn channel(layer: &str, channel: &str) -> Option<&'static str> {
    let color = matches!(layer, "rgba" | "rgb" | "RGBA" | "RGB" | "beauty" | "Combined" | "Ci" | "Image");
    Some(match (layer, channel) {
        _ if color && matches!(channel, "red" | "Red" | "R" | "r") => "It is `color.r` here.",
        _ if color && matches!(channel, "green" | "Green" | "G" | "g") => "It is `color.g` here.",
        _ if color && matches!(channel, "blue" | "Blue" | "B" | "b") => "It is `color.b` here.",
        _ if color && matches!(channel, "alpha" | "Alpha" | "A" | "a") => "It is `alpha` here.",
        ("depth" | "Depth", "Z" | "z") => "It is `depth` here.",
        ("forward" | "motion", "u") => "It is `motion.x` here.",
        ("forward" | "motion", "v") => "It is `motion.y` here.",
        _ => return None,
    })
}

/// How to mend a variable that nothing has: what it is called here, and which name it may be a slip of. `own` are the
/// names that the program gives itself, `others` those that come from elsewhere.
pub fn instead_of_variable<'a>(
    name: &str,
    own: impl Iterator<Item = &'a str>,
    others: impl Iterator<Item = &'a str>,
) -> Vec<String> {
    let here = variable(name);
    let near = match here {
        // A word that is known from elsewhere is no slip of a word that is known here.
        Some(_) => nearest(name, own),
        None => nearest(name, own.chain(others)),
    };
    let near = near.map(|near| format!("Did you mean `{near}`?"));
    near.into_iter().chain(here.map(String::from)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resolve::{is_standard_function, names};
    use crate::syntax;

    /// The pieces of a sentence that are code.
    fn code(sentence: &str) -> impl Iterator<Item = &str> {
        sentence.split('`').skip(1).step_by(2)
    }

    #[test]
    fn no_word_is_one_of_ours_and_none_stands_twice() {
        for (table, of) in [(VARIABLES, "variables"), (FUNCTIONS, "functions")] {
            let words: Vec<&str> = table.iter().flat_map(|(words, _)| words.iter().copied()).collect();
            for (i, word) in words.iter().enumerate() {
                assert!(!words[..i].contains(word), "{word} stands twice among the {of}");
                let variable = names::constant(word).is_some()
                    || names::is_system(word)
                    || names::USUAL_INPUTS.contains(word);
                assert!(of != "variables" || !variable, "{word} is a variable");
                assert!(of != "functions" || !is_standard_function(word), "{word}() is a function");
            }
        }
    }

    #[test]
    fn what_is_offered_can_be_written() {
        for (words, sentence) in VARIABLES.iter().chain(FUNCTIONS) {
            assert!(sentence.ends_with('.') && !sentence.contains("  "), "{sentence}");
            for code in code(sentence) {
                let text = code
                    .split_once(" = ")
                    .filter(|(left, _)| left.len() == 1)
                    .map_or(code, |(_, value)| value);
                let source = crate::diagnostic::SourceId::default();
                assert!(syntax::parse_expression(source, text).is_some(), "{}: `{code}`", words[0]);
                for call in code.match_indices('(').map(|(at, _)| &code[..at]) {
                    let name = call.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or("");
                    assert!(name.is_empty() || is_standard_function(name), "{}: {name}()", words[0]);
                }
            }
        }
    }

    #[test]
    fn renderers_names_lead_to_ours() {
        let cases = [
            ("P", "`point`"),
            ("N", "`normal`"),
            ("Z", "`depth`"),
            ("Ci", "`color`"),
            ("Cs", "`color`"),
            ("Cd", "`color`"),
            ("Oi", "`alpha`"),
            ("Os", "`alpha`"),
            ("st", "`uv`"),
            ("s", "`uv.x`"),
            ("t", "`uv.y`"),
            ("u", "`uv.x`"),
            ("v", "`uv.y`"),
            ("E", "`eye`"),
            ("L", "direction("),
            ("V", "`I`"),
            ("iTime", "`frame"),
            ("gl_FragCoord", "`pixel`"),
            ("position", "`point`"),
            ("texcoord", "`uv`"),
            ("objectid", "`surface`"),
            ("viewdirection", "`I`"),
        ];
        for (word, ours) in cases {
            let hints = instead_of_variable(word, [].into_iter(), ["pi", "point", "color"].into_iter());
            assert!(hints.len() == 1 && hints[0].contains(ours), "{word}: {hints:?}");
        }
        let own = instead_of_variable("Pos", ["pos"].into_iter(), [].into_iter());
        assert_eq!(own, ["Did you mean `pos`?"]);
    }

    #[test]
    fn functions_of_other_languages_lead_to_ours() {
        for (word, ours) in [
            ("ramp", "spline("),
            ("fit", "mix("),
            ("rand", "random("),
            ("hash", "random("),
            ("luma", "luminance("),
            ("premult", "`color * alpha`"),
            ("unpremult", "color / alpha"),
            ("blur", "width ="),
            ("clamp01", "clamp("),
            ("saturate", "clamp("),
            ("fract", "frac("),
            ("texture2D", "texture("),
            ("tex2D", "texture("),
            ("smooth", "smoothstep("),
            ("fmod", "`a % b`"),
            ("atan2", "atan("),
            ("rsqrt", "1 / sqrt(x)"),
            ("inversesqrt", "1 / sqrt(x)"),
            ("cellnoise", "random(floor(p))"),
            ("voronoi", "cellular"),
            ("worley", "cellular"),
            ("fbm", "fBm("),
            ("curlnoise", "curl("),
            ("noise1", "Noise("),
            ("snoise", "Noise("),
            ("aces", "no tone mapping"),
            ("srgb", "linear_to_srgb("),
        ] {
            assert!(function(word).is_some_and(|f| f.contains(ours)), "{word}: {:?}", function(word));
        }
        // These are functions here, of the same meaning.
        for name in [
            "lerp",
            "frac",
            "smoothstep",
            "step",
            "mod",
            "pow",
            "pnoise",
            "degrees",
            "radians",
            "sign",
            "distance",
        ] {
            assert!(is_standard_function(name), "{name}");
        }
    }
}
