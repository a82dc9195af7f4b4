" Vim syntax file for the language of pse, the pixel stream editor.
if exists("b:current_syntax")
  finish
endif

" The lists are tested against the language; UPDATE=1 cargo test --test language editors writes them anew.
" lists begin
syn keyword pseKeyword if else while for in break continue function return param
syn keyword pseKeyword import
syn keyword pseFunction abs sign floor ceil round trunc frac mod min max
syn keyword pseFunction clamp sqrt cbrt exp exp2 log log2 log10 pow hypot
syn keyword pseFunction isnan isinf isfinite sin cos tan asin acos atan sinh
syn keyword pseFunction cosh tanh radians degrees dot cross norm length direction distance
syn keyword pseFunction reflect refract faceforward rotate size append reverse sum product mean
syn keyword pseFunction all any transform vtransform ntransform multiply inverse transpose determinant identity
syn keyword pseFunction translation scaling rotation step boxstep smoothstep smootherstep catstep pulse pulsetrain
syn keyword pseFunction mix lerp bias gain gammacorrect cycloid Du Dv filterwidth calculatenormal
syn keyword pseFunction spline linear texture environment table luminance hsv_to_rgb rgb_to_hsv hsl_to_rgb rgb_to_hsl
syn keyword pseFunction srgb_to_linear linear_to_srgb blackbody Noise Dnoise Vnoise curl random wiener_error turbulence
syn keyword pseFunction fractalsum fBm ridged hybrid marble_color Colorful color_of_emission color_of_corona wave moving_wave
syn keyword pseFunction makewaves boring_marble marble smooth_corona corona moving_corona waves shown_by_normal diffuse highlight
syn keyword pseFunction over fresnel vnoise gnoise vcnoise scnoise pnoise ambientlight distantlight pointlight
syn keyword pseFunction ambient illuminance specular phong mirrored facets blinn cooktorrance matte plastic
syn keyword pseFunction metal glass footprint checker brick_cell brick brick_groove cellrandom bumped star_distance
syn keyword pseFunction star wallpaper blue_marble granite rock crystal growthrings rings fibres pine
syn keyword pseFunction oak walnut zebrawood metallic cloudplane stars planet_height planet fire firecolor
syn keyword pseFunction sinc soapfilm print
syn keyword pseConstant pi infinity white black gray red green blue cyan magenta
syn keyword pseConstant yellow
syn keyword pseVariable frame begin_frame resolution pixel pixelsize pixel_freq eye surface point normal
syn keyword pseVariable uv depth color alpha albedo motion I dPdu dPdv
" lists end

syn match pseNumber "\v<\d+(\.\d+)?([eE][+-]?\d+)?>"
syn match pseNumber "\v[A-Za-z0-9_.]@1<!\.\d+([eE][+-]?\d+)?>"
syn match pseEscape contained +\\["\\nt]+
syn region pseString start=+"+ skip=+\\.+ end=+"+ oneline contains=pseEscape
syn match pseComment "#.*$" contains=@Spell
syn match pseDefined "\v(^\s*function\s+)@<=[A-Za-z_]\w*"
syn match pseMember "\v(\w|[)\]])@1<=\.[A-Za-z_]\w*"

hi def link pseKeyword Keyword
hi def link pseFunction Function
hi def link pseDefined Function
hi def link pseConstant Constant
hi def link pseVariable Identifier
hi def link pseNumber Number
hi def link pseString String
hi def link pseEscape SpecialChar
hi def link pseComment Comment

let b:current_syntax = "pse"
