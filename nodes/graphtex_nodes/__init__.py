"""The node library of graphtex: each public name is a node, callable on plain arrays too."""

from graphtex_nodes.image import save as _save  # noqa: F401 (registers the writers)
from graphtex_nodes.image import views as _views  # noqa: F401 (registers the views)
from graphtex_nodes.image.contact_sheet import contact_sheet
from graphtex_nodes.image.convert import (
    grey,
    image_from_angles,
    image_from_displacement,
    image_from_labels,
    image_from_mask,
    image_from_source,
    mask_from_image,
    pick_channels,
)
from graphtex_nodes.image.crop_image import crop_image
from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.flowers import flowers
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.exemplars.sample import sample
from graphtex_nodes.image.exemplars.sample_mask import sample_mask
from graphtex_nodes.image.exemplars.sample_texture import sample_texture
from graphtex_nodes.image.exemplars.sand import sand
from graphtex_nodes.image.exemplars.textons import textons
from graphtex_nodes.image.exemplars.woven_cloth import woven_cloth
from graphtex_nodes.image.load import load_image, load_mask, load_scale
from graphtex_nodes.image.load_data import (
    load_angles,
    load_displacement,
    load_elements,
    load_labels,
    load_points,
    load_source_map,
    load_texture,
    load_view_stack,
)
from graphtex_nodes.image.maps import select_map, split_maps, stack_maps
from graphtex_nodes.image.normals import normals_from_height
from graphtex_nodes.image.shrink_image import shrink_image
from graphtex_nodes.perspective.complete import complete
from graphtex_nodes.perspective.estimate_angles import estimate_angles
from graphtex_nodes.perspective.exemplar_inpaint import exemplar_inpaint
from graphtex_nodes.perspective.feature_mask import feature_mask
from graphtex_nodes.perspective.feature_scale import feature_scale
from graphtex_nodes.perspective.flow_from_image import flow_from_image
from graphtex_nodes.perspective.flow_from_strokes import flow_from_strokes
from graphtex_nodes.perspective.flow_pattern import flow_pattern
from graphtex_nodes.perspective.optimize import optimize
from graphtex_nodes.perspective.replay import replay
from graphtex_nodes.perspective.resize_scale import resize_scale
from graphtex_nodes.perspective.scale_edit import scale_edit
from graphtex_nodes.perspective.scale_from_angles import scale_from_angles
from graphtex_nodes.perspective.scale_pattern import scale_from_image, scale_pattern
from graphtex_nodes.perspective.view_scale import view_scale
from graphtex_nodes.splicing.align_distributions import align_distributions
from graphtex_nodes.splicing.appearance_vectors import appearance_vectors
from graphtex_nodes.splicing.arrange_path import arrange_path, arrange_points
from graphtex_nodes.splicing.arrange_pattern import arrange_pattern
from graphtex_nodes.splicing.draw_elements import draw_elements
from graphtex_nodes.splicing.extend_texture import extend_texture
from graphtex_nodes.splicing.factor_warp import factor_warp
from graphtex_nodes.splicing.find_textons import find_textons
from graphtex_nodes.splicing.hungarian import hungarian
from graphtex_nodes.splicing.judge_splice import judge_splice
from graphtex_nodes.splicing.load_prepared import (
    load_prepared,
    load_prepared_archive,
    load_texture_folder,
    sample_prepared,
)
from graphtex_nodes.splicing.neighbour_sets import neighbour_sets
from graphtex_nodes.splicing.prepare_texture import prepare_texture, split_prepared
from graphtex_nodes.splicing.rasterize import rasterize
from graphtex_nodes.splicing.refine import refine
from graphtex_nodes.splicing.retile import retile
from graphtex_nodes.splicing.rigid_warp import rigid_warp
from graphtex_nodes.splicing.self_similarity import self_similarity
from graphtex_nodes.splicing.separate_foreground import separate_foreground
from graphtex_nodes.splicing.split_texture import split_texture
from graphtex_nodes.splicing.texture_entry import texture_entry
from graphtex_nodes.splicing.vary_elements import vary_elements

__all__ = [
    "align_distributions",
    "appearance_vectors",
    "arrange_path",
    "arrange_pattern",
    "arrange_points",
    "bricks",
    "complete",
    "contact_sheet",
    "crop_image",
    "draw_elements",
    "estimate_angles",
    "exemplar_inpaint",
    "extend_texture",
    "factor_warp",
    "feature_mask",
    "feature_scale",
    "find_textons",
    "flow_from_image",
    "flow_from_strokes",
    "flow_pattern",
    "flowers",
    "grey",
    "hungarian",
    "image_from_angles",
    "image_from_displacement",
    "image_from_labels",
    "image_from_mask",
    "image_from_source",
    "judge_splice",
    "load_angles",
    "load_displacement",
    "load_elements",
    "load_image",
    "load_labels",
    "load_mask",
    "load_points",
    "load_prepared",
    "load_prepared_archive",
    "load_scale",
    "load_source_map",
    "load_texture",
    "load_texture_folder",
    "load_view_stack",
    "mask_from_image",
    "neighbour_sets",
    "normals_from_height",
    "optimize",
    "pebbles",
    "pick_channels",
    "prepare_texture",
    "rasterize",
    "refine",
    "replay",
    "resize_scale",
    "retile",
    "rigid_warp",
    "sample",
    "sample_mask",
    "sample_prepared",
    "sample_texture",
    "sand",
    "scale_edit",
    "scale_from_angles",
    "scale_from_image",
    "scale_pattern",
    "select_map",
    "self_similarity",
    "separate_foreground",
    "shrink_image",
    "split_maps",
    "split_prepared",
    "split_texture",
    "stack_maps",
    "textons",
    "texture_entry",
    "vary_elements",
    "view_scale",
    "woven_cloth",
]
