// Surfaces under studio light, with a plane that clips them, and lines. Colours leave encoded as sRGB, which is what egui takes.

struct Globals {
    view_projection: mat4x4f,
    eye: vec4f,
    // Towards the key light; its strength.
    key: vec4f,
    // Linear grey from above and from below, and whether colours are shown as they are.
    around: vec4f,
    // What lies beyond dot(xyz, p) = w is clipped.
    clip: vec4f,
    // The colour of a clipped object's inside, linear.
    inside: vec4f,
    // The background at the top and at the bottom, sRGB times alpha.
    top: vec4f,
    bottom: vec4f,
}

struct Material {
    // 1 where what lies beyond the plane is not drawn, 2 where only that is; and how opaque it is.
    flags: vec4f,
}

@group(0) @binding(0) var<uniform> globals: Globals;
@group(1) @binding(0) var map: texture_2d<f32>;
@group(1) @binding(1) var map_sampler: sampler;
@group(1) @binding(2) var<uniform> material: Material;

struct Corner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

@vertex
fn corner(in: Corner) -> Varying {
    var out: Varying;
    out.clip = globals.view_projection * vec4f(in.position, 1.0);
    out.world = in.position;
    out.normal = in.normal;
    out.uv = in.uv;
    out.color = in.color;
    return out;
}

fn decode(s: vec3f) -> vec3f {
    return select(pow((s + 0.055) / 1.055, vec3f(2.4)), s / 12.92, s <= vec3f(0.04045));
}

fn encode(l: vec3f) -> vec3f {
    let c = clamp(l, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

fn lit(base: vec3f, normal: vec3f, world: vec3f) -> vec3f {
    let eye = normalize(globals.eye.xyz - world);
    let half_way = normalize(eye + globals.key.xyz);
    let sky = mix(globals.around.y, globals.around.x, 0.5 + 0.5 * normal.y);
    let key = max(dot(normal, globals.key.xyz), 0.0);
    let front = 0.10 * max(dot(normal, eye), 0.0);
    let gloss = 0.05 * pow(max(dot(normal, half_way), 0.0), 24.0) * key;
    return base * (sky + front + globals.key.w * key) + gloss * globals.key.w;
}

@fragment
fn surface(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let texel = textureSample(map, map_sampler, in.uv);
    let clipped = material.flags.x == 1.0;
    let beyond = dot(globals.clip.xyz, in.world) > globals.clip.w;
    if (clipped && beyond) || (material.flags.x == 2.0 && !beyond) {
        discard;
    }
    var base = texel.rgb * decode(in.color.rgb);
    let eye = globals.eye.xyz - in.world;
    var normal = in.normal / max(length(in.normal), 1e-12);
    if dot(normal, normal) < 0.5 {
        normal = normalize(eye);
    }
    if clipped && !front {
        // Where the plane opens an object, its far inner side stands in for the cap.
        base = globals.inside.rgb;
        normal = globals.clip.xyz;
    } else if dot(normal, eye) < 0.0 && !front {
        normal = -normal;
    }
    let color = select(lit(base, normal, in.world), base, globals.around.z > 0.5);
    let alpha = material.flags.y * in.color.a;
    return vec4f(encode(color) * alpha, alpha);
}

@fragment
fn plain(in: Varying) -> @location(0) vec4f {
    return vec4f(in.color.rgb * in.color.a, in.color.a);
}

struct Behind {
    @builtin(position) clip: vec4f,
    @location(0) down: f32,
}

@vertex
fn behind(@builtin(vertex_index) index: u32) -> Behind {
    let x = f32(index & 1u) * 4.0 - 1.0;
    let y = f32(index >> 1u) * 4.0 - 1.0;
    return Behind(vec4f(x, y, 0.0, 1.0), (1.0 - y) * 0.5);
}

@fragment
fn background(in: Behind) -> @location(0) vec4f {
    return mix(globals.top, globals.bottom, clamp(in.down, 0.0, 1.0));
}
