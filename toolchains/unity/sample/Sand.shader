// A grain: a square that faces the camera, cut to a circle and shaded like a sphere in the room's light. Colours are
// linear.
Shader "Sandglass/Sand" {
  Properties { _Color ("Colour", Color) = (0.76, 0.62, 0.40, 1) }
  SubShader {
    Tags { "RenderType" = "Opaque" "Queue" = "AlphaTest" }
    Pass {
      CGPROGRAM
      #pragma target 4.5
      #pragma vertex vertex
      #pragma fragment fragment
      #include "UnityCG.cginc"

      struct Grain { float3 position; float speed; };
      StructuredBuffer<Grain> _Grains;
      float4x4 _FromScene;
      float _Radius;
      float3 _ToLight;  // in the world
      float3 _Sun, _Ambient;
      sampler2D _Sky;     // what the sand leaves of all light but the main one
      float4 _Rectangle;  // low x, low z, high x, high z
      fixed4 _Color;

      struct Corner { float4 position : SV_POSITION; float2 at : TEXCOORD0; float2 on_floor : TEXCOORD1; };

      Corner vertex(uint index : SV_VertexID) {
        static const float2 corners[6] = { float2(-1, -1), float2(1, -1), float2(1, 1), float2(-1, -1), float2(1, 1), float2(-1, 1) };
        Grain grain = _Grains[index / 6];
        float3 place = grain.position * float3(1, 1, -1);  // right-handed to left-handed
        float4 view = mul(UNITY_MATRIX_V, mul(_FromScene, float4(place, 1)));
        Corner corner;
        corner.at = corners[index % 6];
        corner.on_floor = (grain.position.xz - _Rectangle.xy) / (_Rectangle.zw - _Rectangle.xy);
        view.xy += _Radius * corner.at;
        corner.position = mul(UNITY_MATRIX_P, view);
        return corner;
      }

      fixed4 fragment(Corner corner) : SV_Target {
        float r2 = dot(corner.at, corner.at);
        clip(1 - r2);
        float3 normal = float3(corner.at, sqrt(1 - r2));  // in view space
        float3 light = tex2D(_Sky, corner.on_floor).r * _Ambient + _Sun * saturate(dot(normal, mul((float3x3)UNITY_MATRIX_V, _ToLight)));
        return fixed4(_Color.rgb * light, 1);
      }
      ENDCG
    }
  }
}
