from .texture_area import TextureArea as TextureArea
