from .lexis import Lexis as Lexis
