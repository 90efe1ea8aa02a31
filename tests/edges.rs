//! Rays that pass the edges of triangles closer than f32 can tell, against whole numbers of 128 bits.
use crate::common::rays::Random;
use crate::common::{build, configs};
use crate::soup::Soup;
use flashray::{Ray, Scene};

/// The bits of origin, direction and corners, and whether the ray hits.
type AtEdge = ([u32; 3], [u32; 3], [[u32; 3]; 3], bool);

/// Rays that pass a triangle's edge closer than f32 can tell, and whether they hit: by fractions of whole numbers.
const AT_EDGES: [AtEdge; 6] = [
    (
        EYE,
        [0xbf0a_ba24, 0xbf1f_9465, 0xbf10_4f22],
        [
            [0x3f14_7574, 0x3cfa_4eb2, 0x3f78_5c3e],
            [0x3f15_a139, 0x3d0e_62f2, 0x3f7c_4387],
            [0x3f13_1ffb, 0x3c85_1990, 0x3f7a_3195],
        ],
        true,
    ),
    (
        EYE,
        [0xbf3c_9854, 0xbec6_e1e3, 0xbf0d_b39f],
        [
            [0x3d8e_6051, 0x3f0e_be62, 0x3f76_f8b1],
            [0x3d94_ac04, 0x3f11_d3dc, 0x3f78_607a],
            [0x3d8e_2a1b, 0x3f0d_3f37, 0x3f78_bc9d],
        ],
        true,
    ),
    (
        EYE,
        [0xbef3_24ec, 0xbeed_79c6, 0xbf3f_762a],
        [
            [0x3f79_3bd4, 0x3f21_ef1f, 0x3f6d_3be2],
            [0x3f77_eaa5, 0x3f21_3589, 0x3f6d_7aeb],
            [0x3f7b_a416, 0x3f22_c7a7, 0x3f69_5954],
        ],
        true,
    ),
    (
        EYE,
        [0xbf46_fe7e, 0xbe82_a2b1, 0xbf13_35e3],
        [
            [0x3d6b_68d2, 0x3f66_e3e9, 0x3f78_677b],
            [0x3d64_4b2c, 0x3f68_9b84, 0x3f7b_d41a],
            [0x3d68_2211, 0x3f66_231d, 0x3f78_5852],
        ],
        false,
    ),
    (
        EYE,
        [0xbf30_4b4b, 0xbf01_dbab, 0xbf04_a3bc],
        [
            [0x3c64_fd39, 0x3e01_ac61, 0x3f6a_ba24],
            [0xb9ed_3620, 0x3df6_33fb, 0x3f6c_fb74],
            [0x3c3d_ad11, 0x3e0d_d540, 0x3f6d_28f8],
        ],
        false,
    ),
    (
        [0x404c_cccd, 0x3fd9_999a, 0x400c_cccd],
        [0xbf4a_e605, 0xbe96_1803, 0xbf08_e14c],
        [
            [0xbf8f_9dbb, 0x3dcf_ace6, 0xbf39_cb36],
            [0xbf8f_9dbb, 0x3dcf_ace6, 0xbe86_a61a],
            [0xbf90_ef13, 0x3dcf_ace6, 0xbe86_a61a],
        ],
        false,
    ),
];
const EYE: [u32; 3] = [0x3fee_6d86, 0x3fbf_e521, 0x4014_4610];

/// A scene of one triangle.
fn alone(corners: [[f32; 3]; 3]) -> Soup {
    Soup { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Soup::default() }
}

/// Asks for the ray one by one, alone in a group, and 64 times.
fn all_say(scene: &Scene<'_>, ray: &Ray, hits: bool) {
    assert_eq!((scene.closest_hit(ray).is_some(), scene.any_hit(ray)), (hits, hits), "{ray:?}");
    for rays in [&[*ray; 64][..], &[*ray]] {
        let (mut closest, mut any) = ([None; 64], [false; 64]);
        scene.closest_hits(rays, &mut closest[..rays.len()]);
        scene.any_hits(rays, &mut any[..rays.len()]);
        assert!(closest[..rays.len()].iter().all(|hit| hit.is_some() == hits), "{ray:?}");
        assert!(any[..rays.len()].iter().all(|&hit| hit == hits), "{ray:?}");
    }
}

/// Found among the rays of `benches/peers`.
#[test]
fn rays_that_f32_had_wrong() {
    // Behind the eye, and so much larger that nothing can be told of the others before their own size is asked for.
    let large = [[50.0, 50.0, 50.0], [52.0, 50.0, 50.0], [50.0, 52.0, 53.0]];
    for (origin, dir, corners, hits) in AT_EDGES {
        let (mut soup, ray) = (
            alone(corners.map(|v| v.map(f32::from_bits))),
            Ray::new(origin.map(f32::from_bits), dir.map(f32::from_bits)),
        );
        for _ in 0..2 {
            for config in configs() {
                all_say(&Scene::from_bytes(&build(&soup, &config)).expect("a good blob"), &ray, hits);
            }
            soup.positions.extend(large);
            soup.triangles.push([3, 4, 5]);
        }
    }
}

type Whole = [i128; 3];

fn minus(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Six times the volume between three vectors.
fn volume(a: Whole, b: Whole, c: Whole) -> i128 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

fn floats(v: Whole) -> [f32; 3] {
    v.map(|x| x as f32)
}

/// The signs of the edge functions as f32 alone would have them, of a direction that is largest on the last axis.
fn agree_in_f32(origin: Whole, dir: Whole, corners: [Whole; 3]) -> bool {
    let ([ox, oy, oz], [dx, dy, dz]) = (floats(origin), floats(dir));
    let inv = 1.0 / dz;
    let [a, b, c] = corners.map(floats).map(|[x, y, z]| {
        let z = z - oz;
        [x - ox - dx * inv * z, y - oy - dy * inv * z]
    });
    let edge = |a: [f32; 2], b: [f32; 2]| a[0] * b[1] - a[1] * b[0];
    let signs = [edge(b, c), edge(c, a), edge(a, b)];
    signs.iter().all(|&w| w > 0.0) || signs.iter().all(|&w| w < 0.0)
}

/// Coordinates are whole and small enough to be f32 without rounding: below 2^23, as all distances. So the vertices' places
/// in f64 are off by less than `2^-50 * 2^23`, and a volume, which is an edge function times at most 2^22, by less than
/// `6 * 2^23 * 2^22 * 2^-27`. Rays so near to an edge are left out.
#[test]
fn edges_are_where_the_numbers_given_say() {
    let mut random = Random::new(62);
    let mut near = |range: i128| [0; 3].map(|_: i32| i128::from(random.next()) % (2 * range + 1) - range);
    let (mut hit, mut missed, mut wrong_in_f32) = (0, 0, 0);
    for _ in 0..60 {
        let middle = near(1 << 21);
        let corners = [0; 3].map(|_: i32| {
            let from = near(300_000);
            [middle[0] + from[0], middle[1] + from[1], middle[2] + from[2]]
        });
        if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
            continue;
        }
        let soup = alone(corners.map(floats));
        let blobs: Vec<_> = configs().iter().map(|config| build(&soup, config)).collect();
        let scenes: Vec<_> = blobs.iter().map(|blob| Scene::from_bytes(blob).expect("a good blob")).collect();
        for i in 0..400 {
            // A point beside one of an edge, and an origin so far away that the ray's way there is long.
            let (a, b, share) = (corners[i % 3], corners[(i + 1) % 3], near(500)[0] + 500);
            let beside = near(1);
            let at = [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * share / 1000 + beside[k]);
            let from = near(1 << 20);
            let origin = [at[0] + from[0], at[1] + from[1], at[2] + (1 << 20) + from[2].abs()];
            let dir = minus(at, origin);
            let [a, b, c] = corners.map(|v| minus(v, origin));
            let volumes = [volume(dir, b, c), volume(dir, c, a), volume(dir, a, b)];
            if volumes.iter().any(|v| v.abs() < 1 << 21) {
                continue;
            }
            let hits = volumes.iter().all(|&v| v > 0) || volumes.iter().all(|&v| v < 0);
            let ray = Ray::new(floats(origin), floats(dir)).within(f32::NEG_INFINITY, f32::INFINITY);
            for scene in &scenes {
                assert_eq!((scene.closest_hit(&ray).is_some(), scene.any_hit(&ray)), (hits, hits), "{ray:?}");
            }
            if i % 40 == 0 {
                all_say(&scenes[scenes.len() - 1], &ray, hits);
            }
            *if hits { &mut hit } else { &mut missed } += 1;
            wrong_in_f32 += i32::from(agree_in_f32(origin, dir, corners) != hits);
        }
    }
    assert!(hit > 5_000 && missed > 5_000, "{hit} {missed}");
    assert!(wrong_in_f32 > 0, "the rays are none that f32 has wrong");
}
